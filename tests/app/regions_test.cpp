// Regions of a cloth: which triangles they hold, what the model makes of them, and the ones that are refused.

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>

#include "build_scenes.hpp"
#include "run_program.hpp"
#include "scene/fabrics.hpp"
#include "scene/load.hpp"
#include "scene_equal.hpp"
#include "setup/build.hpp"
#include "setup/mesh_io.hpp"
#include "setup/setup_error.hpp"

namespace drench::testing {
namespace {

/// 2 m by 1 m, cells of 0.1 m; `more`: keys of the cloth.
std::string sheet(const std::string& more) {
  return "drench: 1\ncloth:\n  - name: sheet\n    mesh: {grid: {size: [2, 1], nodes: [21, 11]}}\n    areal_density: "
         "0.2\n" +
         more;
}
constexpr const char* right_half = "{box: {min: [0, -1, -1], max: [2, 1, 1]}, ";

Scene parsed(const std::string& yaml) { return parse_scene(yaml, "regions.yaml"); }
Model model_of(const std::string& yaml) { return build(parsed(yaml)).model; }

/// What a scene is refused with, by the loader or by the set-up.
std::string refusal(const std::string& yaml) {
  try {
    build(parsed(yaml));
  } catch (const SetupError& error) {
    return error.key + ": " + error.what();
  } catch (const SceneError& error) {
    return error.what();
  }
  return "";
}

/// Four quads in a row of x, then a triangle; each a face of the file.
constexpr const char* named_faces = R"(v 0 0 0
v 1 0 0
v 2 0 0
v 3 0 0
v 4 0 0
v 0 0 1
v 1 0 1
v 2 0 1
v 3 0 1
v 4 0 1
v 5 0 0
l 1 2
o shirt
g hem
f 1 6 7 2
g front seam # both
f 2 7 8 3
usemtl felt
f 3 8 9 4
g
usemtl linen
f 4 9 10 5
g tip
f 5 10 11
)";

std::filesystem::path write_named(const test::TempFolder& folder) {
  std::ofstream(folder.path() / "named.obj") << named_faces;
  return folder.path() / "named.obj";
}
std::string named_cloth(const test::TempFolder& folder, const std::string& regions) {
  return fmt::format("drench: 1\ncloth:\n  - name: shirt\n    mesh: {{file: \"{}\"}}\n    regions: [{}]\n",
                     write_named(folder).string(), regions);
}

}  // namespace

TEST(Regions, MassesAddUpExactly) {
  const Model m = model_of(sheet(fmt::format("    regions: [{}areal_density: 0.5}}]\n", right_half)));
  EXPECT_NEAR(sum(m.mesh.solid_mass), 0.2 * 1 + 0.5 * 1, 1e-14);
  double at_seam = 0;
  for (std::size_t n = 0; n < m.mesh.solid_mass.size(); ++n)
    if (std::fabs(m.mesh.rest_position[n][0]) < 1e-12) at_seam += m.mesh.solid_mass[n];
  EXPECT_NEAR(at_seam, 0.1 * (0.5 * 0.2 + 0.5 * 0.5), 1e-14);
}

TEST(Regions, AClothWithoutHasNoArraysForThem) {
  const Model m = model_of(sheet("    porous: {}\n"));
  EXPECT_FALSE(m.has_regions());
  EXPECT_TRUE(m.patches.empty() && m.mesh.node_material.empty() && m.mesh.triangle_material.empty() &&
              m.samples.material.empty());
}

/// A region that names nothing that differs leaves every number of the model as it was.
TEST(Regions, OneOfTheSameFabricChangesNothing) {
  const std::string keys =
      "    stretch: 300\n    bend: 3.0e-4\n    porous: {diffusivity: 2.0e-4, weft_diffusivity: 1.0e-4}\n    warp: [1, "
      "0, 0.3]\n";
  const Model plain = model_of(sheet(keys));
  const Model m = model_of(sheet(keys + fmt::format("    regions: [{}stretch: 300}}]\n", right_half)));
  EXPECT_EQ(m.mesh.solid_mass, plain.mesh.solid_mass);
  for (std::size_t e = 0; e < m.mesh.edge.size(); ++e)
    EXPECT_NEAR(m.mesh.edge_stiffness[e] / plain.mesh.edge_stiffness[e], 1, 1e-14);
  EXPECT_EQ(m.mesh.hinge_stiffness, plain.mesh.hinge_stiffness);
  EXPECT_EQ(m.samples.capacity, plain.samples.capacity);
  ASSERT_EQ(m.fabric.nodes, plain.fabric.nodes);
  for (std::size_t e = 0; e < m.fabric.weight.size(); ++e)
    EXPECT_NEAR(m.fabric.weight[e], plain.fabric.weight[e], 1e-12);
}

TEST(Regions, NodesBetweenThemAreMeans) {
  const Model m = model_of(sheet(fmt::format(
      "    thickness: 0.001\n    friction: 0.2\n    porous: {{solid_fraction: 0.5, max_saturation: 1.2}}\n"
      "    regions: [{}thickness: 0.003, friction: 0.6, porous: {{solid_fraction: 0.25, max_saturation: 1.4}}}}]\n",
      right_half)));
  double capacity = 0, most = 0;
  for (Index n = 0; n < m.mesh.nodes(); ++n) {
    const auto at = static_cast<std::size_t>(n);
    const ClothMaterial& own = m.material_of_node(n);
    const double x = m.mesh.rest_position[at][0];
    if (std::fabs(x) > 1e-9) {
      EXPECT_EQ(own.thickness, x < 0 ? 0.001 : 0.003);
    }
    capacity += m.samples.node_capacity[at];
    most += own.max_saturation * m.samples.node_capacity[at];
    if (std::fabs(x) > 1e-9) continue;
    EXPECT_NEAR(own.thickness, 0.002, 1e-9);
    EXPECT_NEAR(own.friction, 0.4, 1e-9);
    EXPECT_NEAR((1 - own.solid_fraction) * own.thickness, 0.5 * (0.5 * 0.001 + 0.75 * 0.003), 1e-9);
  }
  const double left = 0.5 * 0.001 * m.rest_density, right = 0.75 * 0.003 * m.rest_density;
  EXPECT_NEAR(capacity, left + right, 1e-12 * capacity);
  EXPECT_NEAR(most, 1.2 * left + 1.4 * right, 1e-9 * most);
}

TEST(Regions, TheLastOfTwoCounts) {
  const Model m =
      model_of(sheet("    regions:\n      - {box: {min: [0, -1, -1], max: [2, 1, 1]}, areal_density: 0.5}\n"
                     "      - {box: {min: [0.5, -1, -1], max: [2, 1, 1]}, areal_density: 1}\n"));
  EXPECT_NEAR(sum(m.mesh.solid_mass), 0.2 * 1 + 0.5 * 0.5 + 1 * 0.5, 1e-14);
  EXPECT_NE(refusal(sheet("    regions:\n      - {box: {min: [0.5, -1, -1], max: [2, 1, 1]}, bend: 1.0e-3}\n"
                          "      - {box: {min: [0, -1, -1], max: [2, 1, 1]}, bend: 1.0e-3}\n"))
                .find("cloth.0.regions.0: cloth 'sheet': region 0 (box) has no triangles; allowed: "),
            std::string::npos);
}

TEST(Regions, FacesHaveTheNamesOfTheirFile) {
  const test::TempFolder folder;
  const SurfaceMesh mesh = read_mesh(write_named(folder).string(), "", {.groups = true});
  ASSERT_EQ(mesh.triangles.size(), 9u);
  const std::map<std::string, std::vector<Index>> expected{{"shirt", {0, 1, 2, 3, 4, 5, 6, 7, 8}},
                                                           {"hem", {0, 1}},
                                                           {"front", {2, 3, 4, 5}},
                                                           {"seam", {2, 3, 4, 5}},
                                                           {"felt", {4, 5}},
                                                           {"linen", {6, 7, 8}},
                                                           {"tip", {8}}};
  EXPECT_EQ(mesh.groups, expected);
  EXPECT_TRUE(read_mesh(write_named(folder).string(), "").groups.empty());
}

TEST(Regions, AGroupIsARegion) {
  const test::TempFolder folder;
  const Model m = model_of(named_cloth(folder, "{group: hem, areal_density: 1}, {group: felt, areal_density: 3}"));
  EXPECT_NEAR(sum(m.mesh.solid_mass), 1 + 3 + 2.5 * 0.2, 1e-14);
}

/// A strip of 40 by 4 cells whose points have the attributes wax, from 0 to 1 along x, and grey, the same of 255.
std::string painted_cloth(const test::TempFolder& folder, const std::string& keys) {
  constexpr int cells = 40, rows = 4;
  std::ofstream out(folder.path() / "strip.ply");
  out << fmt::format(
      "ply\nformat ascii 1.0\nelement vertex {}\nproperty float x\nproperty float y\nproperty float z\nproperty "
      "double wax\nproperty uchar grey\nelement face {}\nproperty list uchar int vertex_indices\nend_header\n",
      (cells + 1) * (rows + 1), cells * rows);
  for (int j = 0; j <= rows; ++j)
    for (int i = 0; i <= cells; ++i)
      out << fmt::format("{} 0 {} {} {}\n", 0.05 * i, 0.05 * j, double(i) / cells, 255 * i / cells);
  for (int j = 0; j < rows; ++j)
    for (int i = 0; i < cells; ++i) {
      const int a = j * (cells + 1) + i;
      out << fmt::format("4 {} {} {} {}\n", a, a + cells + 1, a + cells + 2, a + 1);
    }
  return fmt::format("drench: 1\ncloth:\n  - name: strip\n    mesh: {{file: \"{}\"}}\n    friction: 0.2\n{}",
                     (folder.path() / "strip.ply").string(), keys);
}

TEST(Regions, APaintedOneBlendsByItsAttribute) {
  const test::TempFolder folder;
  const std::string porous =
      "    areal_density: 0.2\n    stretch: 400\n    porous: {uptake_velocity: 0.02, permeability: 1.0e-11}\n";
  for (const std::string& attribute : {std::string("wax"), std::string("grey")}) {
    const Model m = model_of(painted_cloth(
        folder, porous + "    regions: [{attribute: " + attribute +
                    ", friction: 1, areal_density: 0.6, stretch: 1200, porous: {absorption: 0, permeability: 0}}]\n"));
    double density = 0;
    for (Index n = 0; n < m.mesh.nodes(); ++n) {
      const ClothMaterial& own = m.material_of_node(n);
      const double wax = m.mesh.rest_position[static_cast<std::size_t>(n)][0] / 2;
      EXPECT_NEAR(own.friction, 0.2 + 0.8 * wax, 0.8 / 32 + 0.02) << wax;
      EXPECT_NEAR(own.friction_wet, own.friction, 1e-12);
      density += m.mesh.solid_mass[static_cast<std::size_t>(n)] / (2 * 0.2);
    }
    EXPECT_NEAR(density, 0.4, 0.005);
    for (Index t = 0; t < m.mesh.triangles(); ++t) {
      const ClothMaterial& own = m.material_of_triangle(t);
      const double part = (own.areal_density - 0.2) / 0.4;
      EXPECT_NEAR(own.permeability, (1 - part) * 1e-11, 1e-14);
      EXPECT_NEAR(own.uptake_velocity, (1 - part) * 0.02, 1e-9);
      EXPECT_NEAR(m.fabric_of_triangle(t).stretch, 400 + 800 * part, 1e-9);
    }
    EXPECT_EQ(m.patches.size(), 16u) << "no materials for single nodes";
  }
  const Model blocked = model_of(painted_cloth(folder,
                                               "    warp: [1, 0, 0]\n    porous: {diffusivity: 2.0e-4, "
                                               "weft_diffusivity: 1.0e-4}\n    regions: [{attribute: wax, "
                                               "porous: {diffusivity: 0}}]\n"));
  for (const double weight : blocked.fabric.weight) EXPECT_TRUE(std::isfinite(weight));
  EXPECT_GT(blocked.fabric.weight.size(), 300u);
  for (const auto& [keys, key] : {std::pair{"uptake_velocity: 0.01", "porous.uptake_velocity"},
                                  {"permeability: 1.0e-11, fibre_diameter: 1.0e-5", "porous.fibre_diameter"}})
    EXPECT_NE(
        refusal(painted_cloth(folder, fmt::format("    porous: {{permeability: 1.0e-11}}\n    regions: [{{attribute: "
                                                  "wax, porous: {{{}}}}}]\n",
                                                  keys)))
            .find(fmt::format("cloth.0.regions.0.{}: differs in kind from that of the cloth", key)),
        std::string::npos)
        << keys;
  const std::string painted =
      painted_cloth(folder, "    pin: [{edges: true}]\n    regions: [{attribute: wax, friction: 1}]\n");
  EXPECT_EQ(build(parsed(painted)).warnings, std::vector<std::string>());
  std::string text = test::read_text(folder.path() / "strip.ply");
  test::write_text(folder.path() / "strip.ply", text.replace(text.find(" 1 255\n"), 7, " 50 255\n"));
  const std::vector<std::string> lines = build(parsed(painted)).warnings;
  ASSERT_EQ(lines.size(), 1U);
  EXPECT_NE(lines[0].find("the attribute 'wax' of 1 points is not 0 to 1"), std::string::npos) << lines[0];
  EXPECT_EQ(refusal(painted_cloth(folder, "    regions: [{attribute: wex, friction: 1}]\n")),
            "cloth.0.regions.0.attribute: cloth 'strip': region wex (painted): the vertices of its mesh have no "
            "attribute 'wex'; allowed: the name of one of their numbers, which lie between 0 and 1");
}

TEST(Regions, BadOnesAreRefusedWithOneLine) {
  const test::TempFolder folder;
  EXPECT_EQ(refusal(named_cloth(folder, "{group: him, bend: 0}")),
            "cloth.0.regions.0.group: cloth 'shirt': region him: its mesh has no group 'him'; allowed: felt, front, "
            "hem, linen, seam, "
            "shirt, tip");
  EXPECT_EQ(refusal(sheet("    regions: [{box: {min: [5, -1, -1], max: [6, 1, 1]}, bend: 0}]\n")),
            "cloth.0.regions.0: cloth 'sheet': region 0 (box) has no triangles; allowed: a place with "
            "triangles that no later "
            "region covers");
  const std::pair<const char*, const char*> lines[] = {
      {"{group: hem, bend: 0}",
       "regions.0.group: applies only to meshes with groups, and a grid has none; allowed: box, or an .obj file"},
      {"{attribute: wax, bend: 0}",
       "regions.0.attribute: applies only to .ply files, which have vertex attributes; allowed: box, or a .ply file"},
      {"{bend: 0}", "regions.0: has none of the keys group, box, attribute; allowed: exactly one of them"},
      {"{box: {min: [0, -1, -1], max: [2, 1, 1]}, strain_limit: 0.1}",
       "regions.0.strain_limit: cannot differ between regions; allowed: only as a key of the cloth"},
      {"{box: {min: [0, -1, -1], max: [2, 1, 1]}, porous: {capillary_height: 1}}",
       "regions.0.porous.capillary_height: cannot differ between regions; allowed: only as a key of the cloth"},
      {"{box: {min: [0, -1, -1], max: [2, 1, 1]}, bending: {warp: 1.0e-5}}",
       "regions.0.bending: does not apply, because the cloth has no bending; allowed: bend"},
      {"{box: {min: [0, -1, -1], max: [2, 1, 1]}, membrane: {warp: 100}}",
       "regions.0.membrane: lacks warp or weft, and the cloth has no membrane to take them from; allowed: warp, weft "
       "and shear"},
      {"{box: {min: [0, -1, -1], max: [2, 1, 1]}, porous: {}}",
       "regions.0.porous: applies only to absorbent cloth; allowed: only if the cloth has the key porous"},
      {"{box: {min: [0, -1, -1], max: [2, 1, 1]}, thickness: 2}",
       "regions.0.thickness: '2' is out of range; allowed: [1e-6, 1] m"},
      {"{box: {min: [0, -1, -1], max: [2, 1, 1]}, areal_dens: 2}", "did you mean 'areal_density'?"}};
  for (const auto& [region, message] : lines) {
    const std::string found = refusal(sheet(fmt::format("    porous: {{}}\n    regions: [{}]\n", region)));
    const std::string dry = refusal(sheet(fmt::format("    regions: [{}]\n", region)));
    EXPECT_NE((found.find(message) == found.npos ? dry : found).find(message), std::string::npos) << found << "\n"
                                                                                                  << dry;
    EXPECT_EQ(dry.find('\n'), std::string::npos);
  }
  EXPECT_NE(
      refusal(sheet(fmt::format("    porous: {{diffusivity: 0}}\n    regions: [{}porous: {{diffusivity: 1.0e-4}}}}]\n",
                                right_half)))
          .find("regions.0.porous.diffusivity: is above 0, but that of the cloth is 0"),
      std::string::npos);
}

TEST(Regions, TakeWhatTheyNameAndKeepTheRest) {
  const Scene scene =
      parsed(sheet("    membrane: {warp: 800, weft: 300, shear: 60, wet: 0.5}\n    bending: {warp: 2.0e-4, weft: "
                   "5.0e-5, twist: 1.0e-4}\n    warp: [1, 0, 0]\n"
                   "    friction: 0.7\n    porous: {uptake_velocity: 0.03, diffusivity: 2.0e-4, weft_diffusivity: "
                   "1.0e-4, capillary_height: 0.2}\n"
                   "    regions:\n      - {box: {min: [0, -1, -1], max: [2, 1, 1]}, membrane: {warp: 900}, bending: "
                   "{twist: 3.0e-4}, porous: {absorption: 0.02}}\n"
                   "      - {box: {min: [0.5, -1, -1], max: [2, 1, 1]}, stretch: 70, porous: {diffusivity: 0}}\n"));
  const MaterialScene &first = scene.cloths[0].regions.at(0).material, &second = scene.cloths[0].regions.at(1).material;
  EXPECT_EQ(first.membrane.value(), (MembraneScene{900, 300, 60, 0.5}));
  EXPECT_EQ(first.bending.value(), (PlateScene{2.0e-4, 5.0e-5, 3.0e-4}));
  EXPECT_EQ(first.friction, 0.7);
  EXPECT_EQ(first.uptake_velocity, 0);
  EXPECT_EQ(first.absorption, 0.02);
  EXPECT_EQ(first.capillary_height, 0.2);
  EXPECT_FALSE(second.membrane);
  EXPECT_EQ(second.stretch, 70);
  EXPECT_EQ(second.uptake_velocity, 0.03);
  EXPECT_FALSE(second.weft_diffusivity);
  EXPECT_TRUE(same_scene(parsed(to_yaml(scene)), scene));
}

TEST(Regions, ReadTheKeysOfWovenRegions) {
  const test::TempFolder folder;
  write_named(folder);
  const Scene scene = parse_scene(R"(drench: 1
cloth:
  - mesh: {file: named.obj}
    membrane: {warp: 900, weft: 450, shear: 90}
    bending: {warp: 2.0e-4, weft: 1.0e-4, twist: 1.4e-4}
    warp: [1, 0, 0]
    porous: {}
    regions:
      - {group: hem, membrane: {warp: 901, weft: 451, shear: 91, wet: 0.6, warp_locking: 0.3,
            weft_locking: 0.4}, porous: {hygral_expansion: 0.02},
            bending: {warp: 3.0e-4, weft: 4.0e-4, twist: 5.0e-4}, warp: [1, 0, 1]}
      - {group: felt, fabric: none}
)",
                                  (folder.path() / "scene.yaml").string());
  const RegionScene& hem = scene.cloths[0].regions.at(0);
  EXPECT_EQ(hem.group, "hem");
  EXPECT_EQ(hem.material.membrane.value(), (MembraneScene{901, 451, 91, 0.6, 0.3, 0.4}));
  EXPECT_EQ(hem.material.bending.value(), (PlateScene{3.0e-4, 4.0e-4, 5.0e-4}));
  EXPECT_EQ(scene.cloths[0].regions.at(1).material, scene.cloths[0].material);
  const Model m = build(scene).model;
  for (std::size_t t = 0; t < m.mesh.triangle.size(); ++t)  // the hem's warp lies askew
    EXPECT_NEAR(m.mesh.triangle_warp[t][2], t < 2 ? std::sqrt(0.5) : 0, 1e-12) << t;
}

TEST(Regions, TakeTheValuesOfAFabric) {
  const std::string yaml = sheet(
      "    fabric: cotton_interlock\n    porous: {capillary_height: 0.4}\n    warp: [1, 0, 0]\n"
      "    regions: [{box: {min: [0, -1, -1], max: [2, 1, 1]}, fabric: denim_11oz, thickness: 0.002}]\n");
  const MaterialScene m = parsed(yaml).cloths[0].regions.at(0).material;
  EXPECT_EQ(m.areal_density, 0.324);
  EXPECT_EQ(m.thickness, 0.002);
  EXPECT_EQ(m.membrane.value(), (MembraneScene{2028, 410.7, 53.39, 1}));
  EXPECT_EQ(m.bending.value(), (PlateScene{1.6e-5, 2.42e-5, 1.65e-5}));
  EXPECT_EQ(m.solid_fraction, 0.309);
  EXPECT_EQ(m.capillary_height, 0.4);
  const test::TempFolder folder;
  test::write_text(folder.path() / "scene.yaml", yaml);
  const std::string out = test::run_drench(folder.path(), {"check", "scene.yaml"}).out;
  EXPECT_NE(out.find("fabric denim_11oz of region 0 (box) of cloth sheet:\n"
                     "  areal_density 0.324 kg/m² = 324 g/m² (measured)\n"
                     "  membrane.warp 2028.0 N/m, "),
            out.npos)
      << out;
  EXPECT_NE(out.find("  not used: thickness, porous.diffusion_exponent, porous.capillary_height\n"), out.npos) << out;
  EXPECT_NE(out.find("region 0 (box) of sheet: 200 triangles"), out.npos) << out;
}

}  // namespace drench::testing
