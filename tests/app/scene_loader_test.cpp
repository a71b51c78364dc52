// The scene loader: good scenes and their defaults, bad ones and their messages, --set, to_yaml, random damage.

#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <random>
#include <string>

#include "bad_scenes.hpp"
#include "good_scenes.hpp"
#include "paths.hpp"
#include "scene/load.hpp"
#include "scene_equal.hpp"

namespace drench::testing {

namespace fs = std::filesystem;

namespace {

/// A folder of its own with exists.obj, mesh.PLY and folder.obj/, removed at the end.
class Folder {
 public:
  Folder() {
    path_ = fs::temp_directory_path() / ("drench_scene_loader_" + std::to_string(::getpid()));
    fs::create_directories(path_ / "folder.obj");
    std::ofstream(path_ / "exists.obj") << "v 0 0 0\n";
    std::ofstream(path_ / "mesh.PLY") << "ply\n";
  }
  ~Folder() {
    std::error_code error;
    fs::remove_all(path_, error);
  }
  std::string file(const std::string& name) const { return (path_ / name).string(); }

 private:
  fs::path path_;
};

const Folder& folder() {
  static const Folder the_folder;
  return the_folder;
}

Scene parse(const std::string& yaml, const std::vector<std::string>& overrides = {}) {
  return parse_scene(yaml, folder().file("test.yaml"), overrides);
}

/// What the error says, "" when the scene loads. The folder's name is cut off.
std::string error_of(const std::string& yaml, const std::vector<std::string>& overrides = {}) {
  try {
    parse(yaml, overrides);
  } catch (const SceneError& error) {
    const std::string what = error.what(), prefix = folder().file("");
    return what.compare(0, prefix.size(), prefix) == 0 ? what.substr(prefix.size()) : what;
  }
  return "";
}

std::string load_error(const std::string& path) {
  try {
    load_scene(path);
  } catch (const SceneError& error) {
    return error.what();
  }
  return "";
}

TEST(SceneLoader, LeavesTheStructsDefaults) {
  Scene expected;
  expected.fluid.present = true;
  expected.fluid.blocks = {{{{0, 0, 0}, {1, 1, 1}}, {0, 0, 0}}};
  EXPECT_TRUE(parse(minimal) == expected);

  expected.cloths.emplace_back();
  expected.cloths[0].grid = GridScene{};
  EXPECT_TRUE(parse(fluid_and_cloth) == expected);

  expected.cloths[0].porous.present = true;
  EXPECT_TRUE(parse(fluid_and_cloth, {"cloth.0.porous={}"}) == expected);
}

TEST(SceneLoader, ReadsEveryKey) {
  Scene s;
  s.time = {0.002, 3.5, TimeMode::cfl, 0.3};
  s.gravity = {0.1, -1.62, 0.2};
  s.field = {true, {0.5, 0, -0.5}, {1, 2, 0}};
  s.domain = {{-2, -3, -4}, {5, 6, 7}};
  s.output = {0.05, 0.7, true, true, 0.75};
  s.processes = {false, false, false, false, false};
  s.sort = SortMethod::bitonic_naive;
  s.through_cloth = true;
  FluidScene& f = s.fluid;
  f.present = true;
  f.spacing = 0.02;
  f.density = 998;
  f.viscosity = 2.0e-6;
  f.surface_tension = 0.05;
  f.kernel = KernelKind::wendland;
  f.support = 2.5;
  f.micropolar = {true, 2.0e-3, 3, 1.0e-4, 0.25};
  f.solver = {2.0e-3, 3.0e-3, 50, 1, 0.75};
  f.blocks = {{{{0, 0.1, 0}, {0.3, 0.4, 0.5}}, {1, 2, 3}}};
  f.jets = {{{1, 1, 1}, 0.07, {0, -2, 0}, 0.5, 1.5},
            {{1, 2, 1}, 0.08, {0, -3, 0}, 0, std::numeric_limits<double>::infinity()}};
  s.cloth_solver = {ClothMethod::xpbd, 2.0e-3, 500};
  ClothScene c;
  c.name = "a \"sheet\" \\ é";
  c.grid = GridScene{{0.6, 0.7}, {13, 17}};
  c.position = {0, 0.5, 0.1};
  c.rotate_axis = {0, 1, 1};
  c.rotate_degrees = 30;
  c.areal_density = 0.3;
  c.thickness = 0.002;
  c.stretch = 400;
  c.bend = 2.0e-4;
  c.damping = 0.5;
  c.strain_damping = 0.02;
  c.friction = 0.4;
  c.friction_wet = 1.1;
  c.damping_wet = 3;
  c.strain_limit = 0.05;
  c.adhesion = 0.01;
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
  c.initial_saturation = {{corner, 0.5}};
  c.hold_saturation = {{corner, 1.25}, {{{0, 0, 0}, {1, 1, 1}}, 0}};
  c.porous = {true, 0.5, 0.02, 0.03, 1.3, 15, 70, 0.6, 0.03, 2.0e-4, DiffusionLaw::degenerate, 0.8, 0.05, true};
  s.cloths.push_back(c);
  ClothScene moved;
  moved.name = "moved";
  moved.grid = GridScene{{1, 1}, {5, 5}};
  moved.pins.resize(2);
  moved.pins[0].kind = PinScene::Kind::nodes;
  moved.pins[0].nodes = {0, 1};
  moved.pins[0].velocity = {0.1, 0, 0.2};
  moved.pins[0].start = 0.5;
  moved.pins[0].end = 2.5;
  moved.pins[1].kind = PinScene::Kind::box;
  moved.pins[1].box = {{0, -1, 0}, {1, 1, 1}};
  moved.pins[1].spin = {{0, 0, 1}, 90};
  moved.pins[1].center = {0, 1, 0};
  s.cloths.push_back(moved);
  ClothScene second;
  second.name = "second";
  second.file = folder().file("exists.obj");
  second.scale = 0.01;
  second.dynamics = false;
  s.cloths.push_back(second);
  s.bodies.resize(4);
  s.bodies[0].box = {{-1, -1, -1}, {1, 2, 1}};
  s.bodies[0].inside = true;
  s.bodies[0].velocity = {0.1, 0, -0.2};
  s.bodies[1].kind = BodyScene::Kind::sphere;
  s.bodies[1].center = {0, 0.2, 0};
  s.bodies[1].radius = 0.25;
  s.bodies[1].dynamic = true;
  s.bodies[1].density = 400;
  s.bodies[2].kind = BodyScene::Kind::plane;
  s.bodies[2].point = {0, -0.5, 0};
  s.bodies[2].normal = {0, 2, 0};
  s.bodies[2].spin = {{1, 0, 0}, 5};
  s.bodies[3].kind = BodyScene::Kind::mesh;
  s.bodies[3].file = folder().file("mesh.PLY");
  s.bodies[3].scale = 1.5;
  s.bodies[3].position = {1, 0, 0};
  s.bodies[3].velocity = {0, 0, 1};
  s.bodies[3].spin = {{0, 0, 1}, -90};
  s.bodies[0].adhesion = 0.02;
  s.bodies[2].adhesion = 0.04;
  s.bodies[3].adhesion = 0.06;

  const Scene loaded = parse(everything);
  EXPECT_TRUE(loaded == s) << to_yaml(loaded) << "\nexpected\n" << to_yaml(s);
  EXPECT_EQ(loaded.path, folder().file("test.yaml"));
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
  EXPECT_TRUE(parse_scene(to_yaml(parse(towel)), folder().file("again.yaml")) == parse(towel));
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

TEST(SceneLoader, RefusesEveryBadSceneWithItsPlace) {
  ASSERT_GE(std::size(bad_scenes), 50u);
  for (const BadScene& bad : bad_scenes) {
    const std::string where = "test.yaml:" + std::to_string(bad.line) + ":" + std::to_string(bad.column) + ": ";
    const std::string start = where + bad.key + ": ", what = error_of(bad.yaml);
    EXPECT_EQ(what.substr(0, start.size()), start) << bad.name << ": " << what;
    EXPECT_NE(what.find(bad.fragment, std::min(what.size(), start.size())), what.npos) << bad.name << ": " << what;
    EXPECT_EQ(what.find('\n'), what.npos) << bad.name;
  }
}

TEST(SceneLoader, SetsValuesByTheirPath) {
  const Scene scene = parse(fluid_and_cloth, {"cloth.0.stretch=300", "fluid.spacing=0.02", "time.mode=cfl",
                                              "gravity=[0, 0, 1]", "fluid.solver.max_iterations=7", "gravity.1=2",
                                              "cloth.0.pin=[{nodes: [1, 2]}]", "cloth.0.porous.diffusivity=0"});
  EXPECT_EQ(scene.cloths[0].stretch, 300);
  EXPECT_EQ(scene.fluid.spacing, 0.02);
  EXPECT_EQ(scene.time.mode, TimeMode::cfl);
  EXPECT_EQ(scene.gravity, (Vec3{0, 2, 1}));
  EXPECT_EQ(scene.fluid.solver.max_iterations, 7);
  EXPECT_EQ(scene.cloths[0].pins.at(0).nodes, (std::vector<Index>{1, 2}));
  EXPECT_TRUE(scene.cloths[0].porous.present);
  EXPECT_EQ(scene.cloths[0].porous.diffusivity, 0);
  EXPECT_EQ(error_of("drench: 1\nfluid:\n", {"fluid.sources=[{block: {min: [0, 0, 0], max: [1, 1, 1]}}]"}), "");
}

TEST(SceneLoader, RefusesBadOverrides) {
  for (const BadOverride& bad : bad_overrides) {
    EXPECT_EQ(error_of(fluid_and_cloth, {bad.override_text}), bad.message) << bad.name;
  }
  const std::string syntax = error_of(fluid_and_cloth, {"fluid.spacing=[1"});
  EXPECT_EQ(syntax.substr(0, 48), "--set fluid.spacing=[1: fluid.spacing: value:1:1") << syntax;
}

TEST(SceneLoader, WritesWhatItReads) {
  for (const std::string& yaml : {std::string(minimal), std::string(fluid_and_cloth), std::string(everything)}) {
    const Scene scene = parse(yaml);
    const std::string written = to_yaml(scene);
    // in another folder: mesh files have become absolute
    Scene again;
    ASSERT_NO_THROW(again = parse_scene(written, "elsewhere/resolved.yaml")) << written;
    EXPECT_TRUE(again == scene) << written;
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
      continue;  // tools/fetch-models fetches the mesh
    ++count;
    Scene scene, again;
    ASSERT_NO_THROW(scene = load_scene(entry.path().string())) << load_error(entry.path().string());
    ASSERT_NO_THROW(again = parse_scene(to_yaml(scene), "resolved.yaml")) << entry.path();
    EXPECT_TRUE(again == scene) << entry.path();
  }
  EXPECT_GT(count, 0);
}

TEST(SceneLoader, NamesFilesThatItCannotRead) {
  EXPECT_EQ(load_error(folder().file("none.yaml")),
            folder().file("none.yaml") + ": cannot be read: No such file or directory");
  EXPECT_EQ(load_error(folder().file("folder.obj")),
            folder().file("folder.obj") + ": is a folder; allowed: a scene file");
  EXPECT_NE(load_error(""), "");
}

TEST(SceneLoader, LoadsAFile) {
  const std::string path = folder().file("scene.yaml");
  std::ofstream(path) << everything;
  EXPECT_TRUE(load_scene(path) == parse(everything));
  EXPECT_EQ(load_scene(path, {"time.end=9"}).time.end, 9);
}

TEST(SceneLoader, RefusesHugeFiles) {
  const std::string path = folder().file("huge.yaml");
  std::ofstream(path) << minimal;
  fs::resize_file(path, std::uintmax_t{100} << 20);
  EXPECT_EQ(load_error(path), path + ": is too large; allowed: 16 MB");
}

TEST(SceneLoader, RefusesDeepNesting) {
  for (const std::size_t levels : {33u, 5'000u, 16'000'000u}) {
    const std::string what = error_of("drench: 1\nfluid: " + std::string(levels, '['));
    EXPECT_NE(what.find("nested too deeply; allowed: 32 levels"), std::string::npos) << what;
  }
  std::string maps = "drench: 1\n";
  for (int i = 0; i < 1000; ++i) maps += std::string(static_cast<std::size_t>(i), ' ') + "a:\n";
  EXPECT_NE(error_of(maps).find("nested too deeply"), std::string::npos);
}

TEST(SceneLoader, RefusesAnchorBombs) {
  std::string bomb = "drench: 1\na0: &a0 [x, x, x, x, x, x, x, x, x, x]\n";
  for (int i = 1; i < 12; ++i) {
    const std::string last = "*a" + std::to_string(i - 1), name = "a" + std::to_string(i);
    bomb.append(name).append(": &").append(name).append(" [").append(last);
    for (int k = 0; k < 9; ++k) bomb.append(", ").append(last);
    bomb += "]\n";
  }
  EXPECT_NE(error_of(bomb).find("too many values; allowed: 300000 in one file"), std::string::npos) << error_of(bomb);
}

TEST(SceneLoader, RefusesMapsWithTooManyKeys) {
  std::string yaml = "drench: 1\n";
  for (int i = 0; i < 2000; ++i) yaml += "k" + std::to_string(i) + ": 1\n";
  EXPECT_EQ(error_of(yaml), "test.yaml:1001:1: syntax: too many keys; allowed: 1000 in one map");
}

/// Damaged scenes load or are refused with one line; anything else (another exception, a crash) fails.
/// DRENCH_FUZZ_SEED and DRENCH_FUZZ_COUNT repeat or lengthen the hunt.
TEST(SceneLoader, SurvivesRandomDamage) {
  const char* seed_text = std::getenv("DRENCH_FUZZ_SEED");
  const char* count_text = std::getenv("DRENCH_FUZZ_COUNT");
  const unsigned long seed = seed_text ? std::stoul(seed_text) : 1;
  const unsigned long count = count_text ? std::stoul(count_text) : 2000;
  const std::string good = everything;
  const std::string marks = "[]{}:,-#&*!|>'\"%@`?\n\t \\.0123456789eE+\x04";
  std::mt19937_64 random(seed);
  const auto below = [&](std::size_t n) { return static_cast<std::size_t>(random() % n); };
  unsigned long refused = 0;
  for (unsigned long run = 0; run < count; ++run) {
    std::string damaged = good;
    for (std::size_t edits = 1 + below(4); edits > 0 && !damaged.empty(); --edits) {
      const std::size_t at = below(damaged.size());
      switch (below(5)) {
        case 0:
          damaged[at] = static_cast<char>(below(256));
          break;
        case 1:
          damaged[at] = marks[below(marks.size())];
          break;
        case 2:
          damaged.insert(at, 1, marks[below(marks.size())]);
          break;
        case 3:
          damaged.erase(at, 1 + below(20));
          break;
        default:
          damaged.insert(at, damaged.substr(below(damaged.size()), 1 + below(60)));
          break;
      }
    }
    try {
      const Scene scene = parse(damaged);
      EXPECT_TRUE(parse_scene(to_yaml(scene), "again.yaml") == scene) << damaged;
    } catch (const SceneError& error) {
      ++refused;
      EXPECT_EQ(std::string(error.what()).find('\n'), std::string::npos) << error.what();
    } catch (const std::exception& error) {
      ADD_FAILURE() << "seed " << seed << ", run " << run << ": " << error.what() << "\n" << damaged;
    }
  }
  EXPECT_GT(refused, count / 4);  // else the damage is too light to mean anything
  EXPECT_LT(refused, count);
}

}  // namespace

}  // namespace drench::testing
