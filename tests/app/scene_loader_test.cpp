// The scene loader: good scenes and their defaults, --set, to_yaml. Bad ones: scene_refusal_test.cpp.

#include <gtest/gtest.h>

#include <fstream>
#include <limits>

#include "good_scenes.hpp"
#include "paths.hpp"
#include "scene_equal.hpp"
#include "scene_folder.hpp"

namespace drench::testing {
namespace {

TEST(SceneLoader, LeavesTheStructsDefaults) {
  Scene expected;
  expected.fluid.present = true;
  expected.fluid.blocks = {{{{0, 0, 0}, {1, 1, 1}}, {0, 0, 0}}};
  EXPECT_TRUE(same_scene(parse(minimal), expected));

  expected.cloths.emplace_back();
  expected.cloths[0].grid = GridScene{};
  EXPECT_TRUE(same_scene(parse(fluid_and_cloth), expected));

  expected.cloths[0].material.porous = true;
  EXPECT_TRUE(same_scene(parse(fluid_and_cloth, {"cloth.0.porous={}"}), expected));
}

// What `everything` of good_scenes.hpp says, section by section.

FluidScene every_liquid_key() {
  FluidScene f;
  f.present = true;
  f.spacing = 0.02;
  f.density = 998;
  f.viscosity = 2.0e-6;
  f.surface_tension = 0.05;
  f.kernel = KernelKind::wendland;
  f.support = 2.5;
  f.micropolar = {true, 2.0e-3, 3, 1.0e-4, 0.25};
  f.solver = {2.0e-3, 3.0e-3, 50, 1, 0.75, 0.25};
  f.wall_pressure = WallPressure::mirrored;
  f.blocks = {{{{0, 0.1, 0}, {0.3, 0.4, 0.5}}, {1, 2, 3}, 0.02}};
  using Shape = BlockScene::Shape;
  f.blocks.push_back({{}, {0, 1, 0}, 0.01, Shape::sphere, {0.1, 0.2, 0.3}, 0.25});
  f.blocks.push_back({{}, {1, 0, 0}, 0.03, Shape::mesh});
  f.blocks.back().placed = {folder().file("mesh.PLY"), 20, LengthUnit::cm, UpAxis::z, {1, 2, 3}, {0, 1, 1}, 20};
  f.blocks.push_back({{}, {0, 0, 1}, 0.05, Shape::particles});
  f.blocks.back().placed = {folder().file("mesh.PLY"), 30, LengthUnit::mm, UpAxis::x, {3, 2, 1}, {1, 1, 0}, 5};
  f.rains = {{{0.5, 2, 0.5}, {0.4, 0.6}, 300, 0.004, Vec3{0, -6, 1}, 0.25, 2, 0.015}};
  f.sprays = {
      {{0, 1, 0.5},
       {1, -2, 0},
       15,
       12,
       2.5,
       {Vec3{0, 0, 0.1}, {{{0, {0, 0, 0}}, {2, {0, 0.2, 0}}}, Interpolation::linear}, {{1, 0, 0}, 20}, Vec3{0, 1, 0}},
       0.75,
       4,
       0.025}};
  f.jets = {{{1, 1, 1}, 0.07, {0, -2, 0}, 0.5, 1.5, 0.04},
            {{1, 2, 1},
             0.08,
             {{{0, {0, -3, 0}}, {0.5, {1, -2, 0.5}}}, Interpolation::linear},
             0,
             std::numeric_limits<double>::infinity(),
             0}};
  JetScene& rectangle = f.jets.emplace_back();
  rectangle.center = {0, 1, 0};
  rectangle.shape = JetScene::Shape::rectangle;
  rectangle.size = {0.2, 0.1};
  rectangle.up = {0, 0, 2};
  rectangle.velocity = {0, -1, 0};
  rectangle.motion = {{0.1, 0, 0},
                      {{{0, {0, 0, 0}}, {1, {0, 0.1, 0}}}, Interpolation::smooth},
                      {{0, 0, 1}, {{{0, 0}, {1, 90}}, Interpolation::linear}},
                      Vec3{0, 2, 0}};
  MeshJetScene& faces = f.mesh_jets.emplace_back();
  faces.placed = {folder().file("mesh.PLY"), 100, LengthUnit::mm, UpAxis::z, {0, 1, 0}, {0, 0, 1}, 8};
  faces.speed = {{{0, 0}, {1, 2}}, Interpolation::linear};
  faces.direction = {0, -1, 0.5};
  faces.motion = {
      {0, 0.1, 0}, {{{0, {0, 0, 0}}, {2, {0.2, 0, 0}}}, Interpolation::linear}, {{1, 0, 0}, 30}, Vec3{1, 0, 0}};
  faces.start = 0.1;
  faces.end = 3;
  faces.concentration = 0.01;
  MeshJetScene& moving = f.mesh_jets.emplace_back();
  moving.placed.file = folder().file("mesh.PLY");
  moving.sequence = {{folder().file("mesh.PLY"), folder().file("mesh.PLY")}, 12};
  moving.speed = 1.5;
  f.drains.resize(3);
  f.drains[0].box = {{-1, -2, -1}, {1, -1, 1}};
  f.drains[0].start = 0.5;
  f.drains[0].end = 2;
  f.drains[1].shape = DrainScene::Shape::sphere;
  f.drains[1].center = {2, 0, 0};
  f.drains[1].radius = 0.3;
  f.drains[2].shape = DrainScene::Shape::plane;
  f.drains[2].point = {0, -2, 0};
  f.drains[2].normal = {0, 2, 0};
  return f;
}

RegionScene every_region_key(const MaterialScene& cloth) {
  RegionScene r;
  r.kind = RegionScene::Kind::box;
  r.box = {{-1, 0, -1}, {0, 1, 0}};
  r.material = cloth;
  r.material.areal_density = 0.9;
  r.material.thickness = 0.003;
  r.material.stretch = 700;
  r.material.bend = 3.0e-4;
  r.material.damping = 0.6;
  r.material.friction = 0.45;
  r.material.friction_wet = 1.2;
  r.material.damping_wet = 4;
  r.material.adhesion = 0.02;
  r.material.has_warp = true;
  r.material.warp = {1, 0, 1};
  r.material.solid_fraction = 0.55;
  r.material.absorption = 0.025;
  r.material.uptake_velocity = 0.035;
  r.material.max_saturation = 1.35;
  r.material.virtual_pressure = 17;
  r.material.emission_angle = 65;
  r.material.emission_velocity = 0.7;
  r.material.diffusivity = 3.0e-4;
  r.material.weft_diffusivity = 6.0e-5;
  r.material.permeability = 3.0e-10;
  r.material.forchheimer = 0;
  r.material.fibre_diameter = 2.0e-5;
  r.material.breakthrough_pressure = 200;
  r.material.critical_saturation = 0.45;
  return r;
}

ClothScene every_cloth_key() {
  ClothScene c;
  c.name = "a \"sheet\" \\ é";
  c.grid = GridScene{{0.6, 0.7}, {13, 17}};
  c.position = {0, 0.5, 0.1};
  c.rotate_axis = {0, 1, 1};
  c.rotate_degrees = 30;
  c.material.areal_density = 0.3;
  c.material.thickness = 0.002;
  c.material.compression = 8000;
  c.material.stretch = 400;
  c.material.bend = 2.0e-4;
  c.material.damping = 0.5;
  c.material.strain_damping = 0.02;
  c.material.friction = 0.4;
  c.material.friction_wet = 1.1;
  c.material.damping_wet = 3;
  c.material.strain_limit = 0.05;
  c.material.adhesion = 0.01;
  c.slip = 0.002;
  c.sample_spacing = 0.009;
  const Box corner{{-1, 0, -1}, {0, 1, 0}};
  c.pins.resize(4);
  c.pins[1].kind = PinScene::Kind::edges;
  c.pins[2].kind = PinScene::Kind::box;
  c.pins[2].box = corner;
  c.pins[3].kind = PinScene::Kind::nodes;
  c.pins[3].nodes = {3, 220};
  c.self_collision = true;
  c.dynamics = false;
  c.initial_saturation = {{corner, 0.5, 0.01}};
  c.hold_saturation = {{corner, 1.25, 0}, {{{0, 0, 0}, {1, 1, 1}}, 0, 0.03}};
  c.initial_stain = {{corner, 0.05}};
  c.material.porous = true;
  c.material.solid_fraction = 0.5;
  c.material.absorption = 0.02;
  c.material.uptake_velocity = 0.03;
  c.material.max_saturation = 1.3;
  c.material.virtual_pressure = 15;
  c.material.emission_angle = 70;
  c.material.emission_velocity = 0.6;
  c.material.emission_ramp = 0.03;
  c.material.diffusivity = 2.0e-4;
  c.material.weft_diffusivity = 5.0e-5;
  c.material.diffusion = DiffusionLaw::degenerate;
  c.material.capillary_height = 0.8;
  c.material.wet_adhesion = 0.05;
  c.material.film = 4.0e-4;
  c.material.film_viscosity = 2.0e-6;
  c.material.permeability = 2.0e-10;
  c.material.forchheimer = 2.0e5;
  c.material.breakthrough_pressure = 300;
  c.material.critical_saturation = 0.4;
  c.material.compressibility = 0.35;
  c.material.contact_wicking = true;
  c.regions.push_back(every_region_key(c.material));
  return c;
}

ClothScene cloth_with_moved_pins() {
  ClothScene moved;
  moved.name = "moved";
  moved.grid = GridScene{{1, 1}, {5, 5}};
  moved.material.membrane = MembraneScene{900, 450, 90, 1, 0.25, 0.5};
  moved.material.has_warp = true;
  moved.material.warp = {0, 0.5, 1};
  moved.pins.resize(3);
  moved.pins[0].kind = PinScene::Kind::nodes;
  moved.pins[0].nodes = {0, 1};
  moved.pins[0].velocity = {0.1, 0, 0.2};
  moved.pins[0].start = 0.5;
  moved.pins[0].end = 2.5;
  moved.pins[1].kind = PinScene::Kind::nodes;
  moved.pins[1].nodes = {3};
  moved.pins[1].stiffness = 500;
  moved.pins[1].release = 3;
  moved.velocity = {3, 0, -0.5};
  moved.pins[1].velocity = {{{0, {0, 0, 0}}, {1, {0, 1, 0}}}, Interpolation::step};
  moved.pins[1].offset = {{{0, {0, 0, 0}}, {2, {0.1, 0.2, 0.3}}}, Interpolation::smooth};
  moved.pins[2].kind = PinScene::Kind::box;
  moved.pins[2].box = {{0, -1, 0}, {1, 1, 1}};
  moved.pins[2].spin = {{0, 0, 1}, 90};
  moved.pins[2].center = {0, 1, 0};
  return moved;
}

ClothScene cloth_from_a_file() {
  ClothScene second;
  second.name = "second";
  second.file = folder().file("exists.obj");
  second.scale = 0.01;
  second.unit = LengthUnit::inch;
  second.up = UpAxis::z;
  second.clean = 2e-5;
  second.weld = 1e-5;
  second.dynamics = false;
  second.material.porous = true;
  second.material.diffusion_exponent = 2.5;
  second.material.retention_exponent = 1.5;
  second.material.drainage_height = 1.75;
  second.material.drainage_exponent = 2.25;
  second.material.large_pores = 0.375;
  second.material.large_pore_height = 0.125;
  second.material.pore_narrowing = -0.75;
  second.material.hygral_expansion = 0.0625;
  return second;
}

ClothScene cloth_that_follows_files() {
  ClothScene followed;
  followed.name = "followed";
  followed.file = folder().file("exists.obj");
  followed.clean = 0;
  followed.weld = 0;
  followed.sew.resize(4);
  followed.sew[0].loops = {{0, 1}, {2, 3}};
  followed.sew[1].kind = SewScene::Kind::groups;
  followed.sew[1].groups = {"left", "right-side"};
  followed.sew[2].kind = SewScene::Kind::pairs;
  followed.sew[2].pairs = {{7, 8}};
  followed.sew[3].kind = SewScene::Kind::file;
  followed.sew[3].file = folder().file("seams.txt");
  followed.sew_time = 0.75;
  followed.pins.resize(3);
  followed.pins[0].kind = PinScene::Kind::nodes;
  followed.pins[0].nodes = {1};
  followed.pins[0].sequence = {{folder().file("exists.obj")}, 30};
  followed.pins[1].kind = PinScene::Kind::nodes;
  followed.pins[1].nodes = {2};
  followed.pins[1].body = "floor";
  followed.pins[2].kind = PinScene::Kind::nodes;
  followed.pins[2].nodes = {3};
  followed.pins[2].sequence.files = {folder().file("cache.mdd")};
  return followed;
}

ClothScene painted_cloth() {
  ClothScene painted;
  painted.name = "painted";
  painted.file = folder().file("mesh.PLY");
  painted.regions.resize(1);
  painted.regions[0].kind = RegionScene::Kind::attribute;
  painted.regions[0].attribute = "wax";
  painted.regions[0].material.friction = 0.9;
  return painted;
}

JointScene every_joint_key() {
  JointScene joint;
  joint.body = "ball";
  joint.to = "floor";
  joint.point = {0, 0.2, 0.25};
  joint.axis = {1, 0, 0};
  joint.limits = {-30, 60};
  joint.motor = {true, {{{0, 0.0}, {1, 90.0}}, Interpolation::linear}, 2};
  return joint;
}

std::vector<BodyScene> every_body_key() {
  std::vector<BodyScene> bodies(4);
  bodies[0].box = {{-1, -1, -1}, {1, 2, 1}};
  bodies[0].inside = true;
  bodies[0].velocity = {0.1, 0, -0.2};
  bodies[1].name = "ball";
  bodies[1].kind = BodyScene::Kind::sphere;
  bodies[1].center = {0, 0.2, 0};
  bodies[1].radius = 0.25;
  bodies[1].dynamic = true;
  bodies[1].density = 400;
  bodies[2].name = "floor";
  bodies[2].kind = BodyScene::Kind::plane;
  bodies[2].point = {0, -0.5, 0};
  bodies[2].normal = {0, 2, 0};
  bodies[2].offset = {{{0, {0, 0, 0}}, {1, {0, 0.5, 0}}}, Interpolation::linear};
  bodies[2].spin = {{1, 0, 0}, {{{0, 5}, {0.5, -5.5}, {2, 0}}, Interpolation::linear}};
  bodies[3].kind = BodyScene::Kind::mesh;
  bodies[3].file = folder().file("mesh.PLY");
  bodies[3].scale = 1.5;
  bodies[3].unit = LengthUnit::mm;
  bodies[3].up = UpAxis::x;
  bodies[3].position = {1, 0, 0};
  bodies[3].place = {0.5, 1, 0.25};
  bodies[3].rotate_axis = {0, 1, 0};
  bodies[3].rotate_degrees = 45;
  bodies[3].stretch = {1, 2, 0.5};
  bodies[3].velocity = {0, 0, 1};
  bodies[3].spin = {{0, 0, 1}, -90};
  bodies[0].slip = std::numeric_limits<double>::infinity();
  bodies[1].slip = 0.05;
  bodies[0].adhesion = 0.02;
  bodies[2].adhesion = 0.04;
  bodies[3].adhesion = 0.06;
  BodyScene moving;
  moving.kind = BodyScene::Kind::mesh;
  moving.file = folder().file("mesh.PLY");
  moving.sequence = {{moving.file, moving.file}, 12};
  bodies.insert(bodies.begin(), moving);
  moving.sequence = {{folder().file("cache.pc2")}, 25};
  bodies.insert(bodies.begin(), moving);
  return bodies;
}

TEST(SceneLoader, ReadsEveryKey) {
  Scene s;
  s.time = {0.002, 3.5, TimeMode::cfl, 0.3, 2e-3};
  s.gravity = {0.1, -1.62, 0.2};
  s.field = {true, {0.5, 0, -0.5}, {1, 2, 0}};
  s.air = {true, 0.25, 35, 0, 0.3, 0.02, {}, true};
  s.domain = {{-2, -3, -4}, {5, 6, 7}};
  s.output = {{}, std::nullopt, 0.05, 0.7, true, true, 0.1, true, 0.75, SurfaceKernel::isotropic, true, true};
  s.processes = {false, false, false, false, false};
  s.sort = SortMethod::bitonic_naive;
  s.through_cloth = true;
  s.cloth_solver = {ClothMethod::xpbd, 2.0e-3, 500};
  s.fluid = every_liquid_key();
  s.cloths = {every_cloth_key(), cloth_with_moved_pins(), cloth_from_a_file(), cloth_that_follows_files(),
              painted_cloth()};
  s.bodies = every_body_key();
  s.joints = {every_joint_key()};

  const Scene loaded = parse(everything);
  EXPECT_TRUE(same_scene(loaded, s)) << to_yaml(loaded) << "\nexpected\n" << to_yaml(s);
  EXPECT_EQ(loaded.path, folder().file("test.yaml"));
}

TEST(SceneLoader, ReadsTheKeysOfWovenCloth) {
  const Scene scene = parse(
      R"(drench: 1
cloth:
  - mesh: {grid: {nodes: [5, 5]}}
    membrane: {warp: 900, weft: 450, shear: 90, wet: 0.6}
    bending: {warp: 2.0e-4, weft: 1.0e-4, twist: 1.4e-4}
    warp: [0, 0.5, 1]
    porous: {diffusion: degenerate, capillary_height: 0.1, drainage_height: 0.3}
)");
  const MaterialScene& fabric = scene.cloths[0].material;
  EXPECT_EQ(fabric.membrane, (MembraneScene{900, 450, 90, 0.6}));
  EXPECT_EQ(fabric.bending, (PlateScene{2.0e-4, 1.0e-4, 1.4e-4}));
  EXPECT_EQ(fabric.warp, (Vec3{0, 0.5, 1}));
  EXPECT_EQ(fabric.drainage_height, 0.3);
  EXPECT_TRUE(same_scene(parse(to_yaml(scene)), scene)) << to_yaml(scene);
}

TEST(SceneLoader, ThePresetSetsWhatTheSwitchesLeaveAlone) {
  const auto processes = [](const std::vector<std::string>& overrides) {
    std::vector<std::string> all{"cloth.0.porous={}"};
    all.insert(all.end(), overrides.begin(), overrides.end());
    return parse(fluid_and_cloth, all).processes;
  };
  EXPECT_TRUE(processes({}) == ProcessScene{});
  EXPECT_TRUE(processes({"preset=none"}) == ProcessScene{});
  EXPECT_TRUE(processes({"preset=baseline"}) == (ProcessScene{false, false, true, true, true}));
  EXPECT_TRUE(processes({"preset=baseline", "processes.direction=on", "processes.diffusion=off"}) ==
              (ProcessScene{true, false, true, true, false}));
}

TEST(SceneLoader, OverfullClothNeedsNoSources) {
  const char* towel = "drench: 1\nfluid: {}\ncloth: [{mesh: {grid: {}}, porous: {}}]\n";
  EXPECT_EQ(error_of(towel), "");
  EXPECT_TRUE(same_scene(parse_scene(to_yaml(parse(towel)), folder().file("again.yaml")), parse(towel)));
}

TEST(SceneLoader, ReadsNumbersAsYamlWritesThem) {
  EXPECT_EQ(parse(minimal, {"fluid.spacing=+.5"}).fluid.spacing, 0.5);
  EXPECT_EQ(parse(minimal, {"fluid.spacing=5.0E-1"}).fluid.spacing, 0.5);
  EXPECT_EQ(parse(minimal, {"fluid.spacing=1."}).fluid.spacing, 1);
  EXPECT_NE(error_of(minimal, {"fluid.spacing=+-1"}), "");
  EXPECT_NE(error_of(minimal, {"fluid.spacing=1_0"}), "");
}

TEST(SceneLoader, ReadsQuotesAndByteOrderMarks) {
  EXPECT_EQ(parse(fluid_and_cloth, {R"(cloth.0.name='it''s "so"')"}).cloths[0].name, "it's \"so\"");
  EXPECT_EQ(parse(fluid_and_cloth, {R"(cloth.0.name="\"\\")"}).cloths[0].name, "\"\\");
  EXPECT_EQ(parse(fluid_and_cloth, {"cloth.0.name=a'b"}).cloths[0].name, "a'b");
  EXPECT_EQ(error_of("\xef\xbb\xbf" + std::string(minimal)), "");
  EXPECT_EQ(error_of("\xef\xbb\xbf"
                     "drench: 'x'"),
            "test.yaml:1:9: drench: 'x' is not a whole number; allowed: [1, 1] (the format's version)");
}

TEST(SceneLoader, AcceptsTheEndsOfClosedRanges) {
  const Scene scene = parse(fluid_and_cloth, {"time.step=1", "fluid.density=1", "cloth.0.porous.solid_fraction=0",
                                              "cloth.0.mesh.grid.nodes=[2, 4096]", "fluid.spacing=10"});
  EXPECT_EQ(scene.time.step, 1);
  EXPECT_EQ(scene.cloths[0].grid->nodes[1], 4096);
  EXPECT_EQ(scene.fluid.spacing, 10);
}

TEST(SceneLoader, AcceptsAnchors) {
  const Scene scene = parse(
      "drench: 1\nfluid: {sources: [{block: {min: &a [0, 0, 0], max: &b [1, 1, 1]}}]}\n"
      "bodies: [{box: {min: *a, max: *b}}]\n");
  EXPECT_TRUE(scene.bodies.at(0).box == scene.fluid.blocks.at(0).box);
}

TEST(SceneLoader, AcceptsAMeshBodyBesideCloth) {
  const std::string yaml =
      "drench: 1\ncloth: [{mesh: {grid: {}}, dynamics: false}]\nbodies: [{mesh: {file: exists.obj}}]\n";
  EXPECT_EQ(error_of(yaml), "");
  EXPECT_EQ(error_of(yaml, {"cloth.0.dynamics=true"}), "") << "whether the mesh is closed shows at set-up";
}

TEST(SceneLoader, SetsValuesByTheirPath) {
  const Scene scene = parse(fluid_and_cloth, {"cloth.0.stretch=300", "fluid.spacing=0.02", "time.mode=cfl",
                                              "gravity=[0, 0, 1]", "fluid.solver.max_iterations=7", "gravity.1=2",
                                              "cloth.0.pin=[{nodes: [1, 2]}]", "cloth.0.porous.diffusivity=0"});
  EXPECT_EQ(scene.cloths[0].material.stretch, 300);
  EXPECT_EQ(scene.fluid.spacing, 0.02);
  EXPECT_EQ(scene.time.mode, TimeMode::cfl);
  EXPECT_EQ(scene.gravity, (Vec3{0, 2, 1}));
  EXPECT_EQ(scene.fluid.solver.max_iterations, 7);
  EXPECT_EQ(scene.cloths[0].pins.at(0).nodes, (std::vector<Index>{1, 2}));
  EXPECT_TRUE(scene.cloths[0].material.porous);
  EXPECT_EQ(scene.cloths[0].material.diffusivity, 0);
  EXPECT_EQ(error_of("drench: 1\nfluid:\n", {"fluid.sources=[{block: {min: [0, 0, 0], max: [1, 1, 1]}}]"}), "");
}

TEST(SceneLoader, WritesWhatItReads) {
  for (const std::string& yaml : {std::string(minimal), std::string(fluid_and_cloth), std::string(everything)}) {
    const Scene scene = parse(yaml);
    const std::string written = to_yaml(scene);
    // in another folder: mesh files have become absolute
    Scene again;
    ASSERT_NO_THROW(again = parse_scene(written, "elsewhere/resolved.yaml")) << written;
    EXPECT_TRUE(same_scene(again, scene)) << written;
    EXPECT_EQ(to_yaml(again), written);
  }
}

TEST(SceneLoader, ReadsAndWritesEverySort) {
  const std::pair<const char*, SortMethod> sorts[] = {{"auto", SortMethod::automatic},
                                                      {"counting", SortMethod::counting},
                                                      {"radix", SortMethod::radix},
                                                      {"bitonic", SortMethod::bitonic},
                                                      {"bitonic_naive", SortMethod::bitonic_naive}};
  for (const auto& [word, sort] : sorts) {
    const Scene scene = parse(fluid_and_cloth, {std::string("neighbors.sort=") + word});
    EXPECT_EQ(scene.sort, sort);
    EXPECT_EQ(parse_scene(to_yaml(scene), "resolved.yaml").sort, sort) << word;
  }
}

TEST(SceneLoader, LoadsAndRewritesEverySceneOfTheProject) {
  int count = 0;
  for (const auto& entry : fs::recursive_directory_iterator(test::scenes_folder())) {
    if (entry.path().extension() != ".yaml") continue;
    if (entry.path().stem() == "rotating_bunny_medium" &&
        !fs::exists(test::scenes_folder() + "/../.deps/models/bunny.obj"))
      continue;  // tools/measure/fetch-models fetches the mesh
    ++count;
    Scene scene, again;
    ASSERT_NO_THROW(scene = load_scene(entry.path().string())) << load_error(entry.path().string());
    ASSERT_NO_THROW(again = parse_scene(to_yaml(scene), "resolved.yaml")) << entry.path();
    EXPECT_TRUE(same_scene(again, scene)) << entry.path();
  }
  EXPECT_GT(count, 0);
}

TEST(SceneLoader, LoadsAFile) {
  const std::string path = folder().file("scene.yaml");
  std::ofstream(path) << everything;
  EXPECT_TRUE(same_scene(load_scene(path), parse(everything)));
  EXPECT_EQ(load_scene(path, {"time.end=9"}).time.end, 9);
}

}  // namespace
}  // namespace drench::testing
