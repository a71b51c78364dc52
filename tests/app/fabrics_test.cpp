// Fabrics with names: every one loads, builds and runs; the scene's own keys go first; the data file is sound, and
// tools/pages/fabrics.py makes tables of the manual from it.

#include "scene/fabrics.hpp"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include "run_program.hpp"
#include "scene/load.hpp"
#include "scene_equal.hpp"
#include "scene_folder.hpp"
#include "validation.hpp"

namespace drench::testing {
namespace {

constexpr const char* wet_scene = R"(drench: 1
time: {step: 0.002, end: 1}
domain: {min: [-1, -1, -1], max: [1, 1, 1]}
fluid: {spacing: 0.02, sources: [{block: {min: [-0.06, 0.012, -0.06], max: [0.06, 0.072, 0.06]}}]}
cloth:
  - name: sheet
    fabric: cotton_interlock
    mesh: {grid: {size: [0.3, 0.3], nodes: [13, 13]}}
    pin: [{corners: true}]
    porous: {}
)";

const Fabric& fabric(const std::string& name) {
  return *std::find_if(fabrics().begin(), fabrics().end(), [&](const Fabric& f) { return f.name == name; });
}

const FabricValue& entry(const std::string& name, const std::string& key) {
  const std::vector<FabricValue>& values = fabric(name).values;
  return *std::find_if(values.begin(), values.end(), [&](const FabricValue& v) { return v.key == key; });
}

double value(const std::string& name, const std::string& key) { return std::stod(entry(name, key).value); }

bool is_its_own(const FabricValue& v) { return v.how == "measured" || v.how == "derived"; }

MaterialScene material(const std::vector<std::string>& overrides = {}) {
  return parse(wet_scene, overrides).cloths.at(0).material;
}

/// What a fabric's number can be, whatever the fabric.
struct Bound {
  double low, high;
};
const std::map<std::string, Bound> bounds{{"areal_density", {0.03, 1}},
                                          {"thickness", {5e-5, 0.01}},
                                          {"membrane.warp", {1, 1e5}},
                                          {"membrane.weft", {1, 1e5}},
                                          {"membrane.shear", {0.1, 1e4}},
                                          {"bending.warp", {1e-7, 1e-3}},
                                          {"bending.weft", {1e-7, 1e-3}},
                                          {"bending.twist", {1e-7, 1e-3}},
                                          {"porous.solid_fraction", {0.05, 0.6}},
                                          {"porous.permeability", {1e-13, 1e-9}},
                                          {"porous.diffusivity", {1e-7, 1e-2}},
                                          {"porous.diffusion_exponent", {0, 10}},
                                          {"porous.capillary_height", {0.01, 1}}};

/// A file beside the scenes of parse().
void write(const std::string& name, const std::string& text) {
  const fs::path path = folder().file(name);
  fs::create_directories(path.parent_path());
  std::ofstream(path) << text;
}

std::string of_fabric(const std::string& fabric, const std::string& keys = "") {
  return "drench: 1\ncloth:\n  - fabric: " + fabric + "\n    mesh: {grid: {nodes: [5, 5]}}\n" + keys;
}

MaterialScene material_of(const std::string& fabric, const std::string& keys = "") {
  return parse(of_fabric(fabric, keys)).cloths.at(0).material;
}

}  // namespace

TEST(FabricFiles, GiveTheirKeysThenThoseOfTheFabricThatTheyName) {
  write("canvas.yaml",
        "about: canvas\nfabric: denim_11oz\nareal_density: 0.41\nmembrane: {warp: 900}\nporous: {permeability: "
        "3.0e-11}\n");
  const MaterialScene dry = material_of("canvas.yaml");
  EXPECT_EQ(dry.areal_density, 0.41);
  EXPECT_EQ(dry.membrane->warp, 900);
  EXPECT_EQ(dry.membrane->weft, value("denim_11oz", "membrane.weft"));
  EXPECT_FALSE(dry.porous);
  const MaterialScene wet = material_of("canvas.yaml", "    areal_density: 0.5\n    porous: {}\n");
  EXPECT_EQ(wet.areal_density, 0.5);
  EXPECT_EQ(wet.permeability, 3e-11);
  EXPECT_EQ(wet.diffusivity, value("denim_11oz", "porous.diffusivity"));
  // As `drench fit` writes it, and one on top of it in a folder of its own.
  write("sub/fitted.yaml",
        "drench: 1\ncloth:\n  - mesh: {grid: {nodes: [3, 3]}}\n    fabric: ../canvas.yaml\n    thickness: 0.001\n");
  const MaterialScene top = material_of("sub/fitted.yaml");
  EXPECT_EQ(top.thickness, 0.001);
  EXPECT_EQ(top.membrane->warp, 900);
  EXPECT_NE(resolved_yaml(parse(of_fabric("canvas.yaml"))).find("areal_density: 0.41  # kg/m², fabric canvas.yaml\n"),
            std::string::npos);
}

/// What a file has and the taker cannot have, or has in another way, is left out.
TEST(FabricFiles, GiveOnlyWhatCountsWhereTheyAreUsed) {
  write(
      "wide.yaml",
      "areal_density: 0.3\nstretch: 700\nbend: 2.0e-4\nfriction: 0.5\nfriction_wet: 1.1\nstrain_limit: "
      "0.2\ncompression: "
      "8000\nporous: {film: 2.0e-4, diffusion: degenerate, capillary_height: 0.2, permeability: 2.0e-11, forchheimer: "
      "9000, compressibility: 0.4, adhesion: 0.05}\n");
  const MaterialScene dry = material_of("wide.yaml");
  EXPECT_EQ(dry.stretch, 700);
  EXPECT_FALSE(dry.friction_wet);
  const MaterialScene woven = material_of(
      "wide.yaml",
      "    membrane: {warp: 100, weft: 90, shear: 20}\n    porous: {diffusion_exponent: 2, fibre_diameter: 1.0e-5}\n");
  EXPECT_EQ(woven.membrane->warp, 100);
  EXPECT_EQ(woven.forchheimer, 0);
  EXPECT_EQ(woven.friction_wet, 1.1);
  EXPECT_EQ(woven.film, 2e-4);
  const MaterialScene hem =
      parse(of_fabric("none",
                      "    porous: {}\n    regions: [{box: {min: [0, -1, -1], max: [1, 1, 1]}, fabric: wide.yaml}]\n"))
          .cloths.at(0)
          .regions.at(0)
          .material;
  EXPECT_EQ(hem.areal_density, 0.3);
  EXPECT_EQ(hem.permeability, 2e-11);
  EXPECT_EQ(hem.film, 0);
}

TEST(FabricFiles, WrongOnesAreRefusedAtTheirPlace) {
  const auto expect = [](const std::string& file, const std::string& text, const std::string& begin) {
    if (!text.empty()) write(file, text);
    const std::string error = error_of(of_fabric(file));
    EXPECT_EQ(error.substr(0, begin.size()), begin);
  };
  expect("none.yaml", "", "test.yaml:3:13: cloth.0.fabric: there is no file '");
  expect("bad.yaml", "areal_density: -1\n", "bad.yaml:1:16: cloth.0.areal_density: '-1' is out of range");
  expect("word.yaml", "colour: red\n",
         "word.yaml:1:1: colour: is no key of a fabric; allowed: fabric, about, areal_density");
  expect("base.yaml", "fabric: denin\n", "base.yaml:1:9: fabric: there is no fabric 'denin'; allowed");
  expect("base.yaml", "fabric: denin_11oz\n",
         "base.yaml:1:9: fabric: there is no fabric 'denin_11oz'; did you mean 'denim_11oz'? allowed: a fabric's name "
         "or file");
  expect("loop.yaml", "fabric: loop.yaml\n", "loop.yaml:1:9: fabric: is more than 8 files deep, or names itself");
  expect("list.yaml", "- 1\n", "list.yaml:1:1: fabric: is not a map");
  expect("dry.yaml", "drench: 1\n", "dry.yaml:1:1: cloth: is missing");
}

TEST(Fabrics, EveryNumberIsWithinBoundsAndHasASource) {
  const std::set<std::string> ways{"measured", "derived", "similar", "assumed"};
  std::set<std::string> sources, names;
  for (const FabricSource& s : fabric_sources()) {
    EXPECT_TRUE(sources.insert(s.name).second) << s.name;
    EXPECT_FALSE(s.title.empty() || s.read.empty()) << s.name;
    EXPECT_TRUE(s.link.starts_with("http")) << s.name;
  }
  EXPECT_GE(fabrics().size(), 8u);
  for (const Fabric& f : fabrics()) {
    EXPECT_TRUE(names.insert(f.name).second) << f.name;
    EXPECT_FALSE(f.about.empty()) << f.name;
    EXPECT_EQ(f.values.size(), bounds.size()) << f.name;
    std::set<std::string> keys;
    for (const FabricValue& v : f.values) {
      const std::string what = f.name + ": " + v.key;
      ASSERT_TRUE(bounds.contains(v.key)) << what;
      EXPECT_TRUE(keys.insert(v.key).second) << what;
      EXPECT_TRUE(std::stod(v.value) >= bounds.at(v.key).low && std::stod(v.value) <= bounds.at(v.key).high) << what;
      EXPECT_TRUE(ways.contains(v.how)) << what;
      EXPECT_TRUE(sources.contains(v.source)) << what << ": " << v.source;
      EXPECT_FALSE(v.note.empty()) << what;
    }
  }
}

TEST(Fabrics, AValueThatIsTakenFromAnotherFabricNamesIt) {
  std::set<std::string> names;
  for (const Fabric& f : fabrics()) names.insert(f.name);
  for (const Fabric& f : fabrics()) {
    for (const FabricValue& v : f.values) {
      const std::string what = f.name + ": " + v.key;
      if (is_its_own(v)) {
        EXPECT_EQ(v.of, "") << what;
        EXPECT_EQ(basis_of(v), v.how) << what;
      } else if (v.of.empty()) {
        EXPECT_EQ(basis_of(v), v.how + ": " + v.note) << what;
        EXPECT_EQ(v.note.find("values of "), v.note.npos) << what << ": name the fabric by the key of";
      } else {
        ASSERT_TRUE(names.contains(v.of) && v.of != f.name) << what << ": " << v.of;
        EXPECT_TRUE(is_its_own(entry(v.of, v.key))) << what << ": " << v.of;
        if (std::stod(v.value) == value(v.of, v.key)) {
          EXPECT_EQ(basis_of(v), v.how + ": of " + v.of) << what;
        }
      }
    }
  }
  EXPECT_EQ(basis_of(entry("wool_weave", "porous.diffusivity")), "assumed: 0.1 times that of sock_nylon");
}

/// Wicking is what differs most between fabrics, and what is measured of the fewest.
TEST(Fabrics, NoneWicksLikeAnotherWithoutSayingSo) {
  std::size_t own = 0;
  for (const Fabric& f : fabrics()) {
    for (const char* key : {"porous.diffusivity", "porous.diffusion_exponent", "porous.capillary_height"}) {
      const FabricValue& v = entry(f.name, key);
      EXPECT_NE(is_its_own(v), !v.of.empty()) << f.name << ": " << key;
      EXPECT_EQ(v.of, entry(f.name, "porous.diffusivity").of) << f.name << ": " << key;
    }
    if (is_its_own(entry(f.name, "porous.diffusivity"))) ++own;
  }
  EXPECT_GE(own, 7u);
}

/// Dry fabric is lighter than fibre of its thickness: the density that the solid fraction was computed with is a
/// fibre's.
TEST(Fabrics, AreAsHeavyAsTheirFibres) {
  for (const Fabric& f : fabrics()) {
    const double fibre =
        value(f.name, "areal_density") / (value(f.name, "thickness") * value(f.name, "porous.solid_fraction"));
    EXPECT_GT(fibre, 1130) << f.name;  // nylon has 1140 kg/m³
    EXPECT_LT(fibre, 1540) << f.name;  // cotton 1520
  }
}

TEST(Fabrics, EveryOneLoadsBuildsAndSteps) {
  for (const Fabric& f : fabrics()) {
    std::string yaml = wet_scene;
    yaml.replace(yaml.find("cotton_interlock"), std::string("cotton_interlock").size(), f.name);
    test::SceneRun run(yaml);
    const auto total = [](const HostState& s) {
      Quanta sum = s.drained;
      for (const Quanta m : s.fluid_mass) sum += m;
      for (const Quanta m : s.node_liquid) sum += m;
      return sum;
    };
    const Quanta before = total(run.initial());
    for (int k = 0; k < 50; ++k) run.step();
    const HostState after = run.state();
    EXPECT_EQ(total(after), before) << f.name;
    EXPECT_GT(*std::max_element(after.node_liquid.begin(), after.node_liquid.end()), 0) << f.name;
    for (const Vec3& x : after.node_position)
      EXPECT_TRUE(std::fabs(x[0]) < 0.2 && std::fabs(x[1]) < 0.2 && std::fabs(x[2]) < 0.2) << f.name;
    for (const Vec3& v : after.node_velocity) EXPECT_LT(std::hypot(v[0], v[1], v[2]), 5) << f.name;
  }
}

TEST(Fabrics, GiveTheirValues) {
  const MaterialScene m = material();
  EXPECT_EQ(m.areal_density, value("cotton_interlock", "areal_density"));
  EXPECT_EQ(m.thickness, value("cotton_interlock", "thickness"));
  EXPECT_EQ(m.membrane.value(), (MembraneScene{68.95, 33.19, 36.86, 1}));
  EXPECT_EQ(m.bending.value(), (PlateScene{5.8e-6, 3.57e-6, 7.69e-6}));
  EXPECT_EQ(m.solid_fraction, value("cotton_interlock", "porous.solid_fraction"));
  EXPECT_EQ(m.diffusion_exponent, 5);
  EXPECT_EQ(m.friction, MaterialScene{}.friction);  // of which no fabric says anything
  EXPECT_TRUE(m.porous);
}

TEST(Fabrics, TheScenesOwnKeysGoFirst) {
  EXPECT_EQ(material({"cloth.0.thickness=0.002"}).thickness, 0.002);
  EXPECT_EQ(material({"cloth.0.membrane.shear=3"}).membrane.value(), (MembraneScene{68.95, 33.19, 3, 1}));
  const MaterialScene stretch = material({"cloth.0.stretch=300", "cloth.0.bend=1e-5"});
  EXPECT_EQ(stretch.stretch, 300);
  EXPECT_FALSE(stretch.membrane || stretch.bending);
  const MaterialScene linear = material({"cloth.0.porous.diffusion=linear"});
  EXPECT_FALSE(linear.diffusion_exponent);
  EXPECT_EQ(linear.capillary_height, value("cotton_interlock", "porous.capillary_height"));
}

TEST(Fabrics, LeaveClothDryThatHasNoKeyPorous) {
  std::string dry = wet_scene;
  dry.erase(dry.find("    porous: {}\n"));
  EXPECT_FALSE(parse(dry).cloths[0].material.porous);
  EXPECT_EQ(parse(dry).cloths[0].material.solid_fraction, MaterialScene{}.solid_fraction);
}

TEST(Fabrics, NoneIsNone) {
  EXPECT_EQ(material({"cloth.0.fabric=none"}), parse(wet_scene, {"cloth.0.fabric=none"}).cloths[0].material);
  EXPECT_EQ(material({"cloth.0.fabric=none"}).areal_density, MaterialScene{}.areal_density);
}

TEST(Fabrics, AResolvedSceneHasTheValuesAndNoName) {
  const Scene scene = parse(wet_scene);
  const std::string resolved = to_yaml(scene);
  EXPECT_EQ(resolved.find("cotton_interlock"), resolved.npos);
  EXPECT_TRUE(same_scene(parse(resolved), scene));
}

TEST(Fabrics, AResolvedSceneSaysHowEachValueIsKnown) {
  std::string yaml = wet_scene;
  yaml += R"(    thickness: 0.0011
    regions: [{fabric: denim_11oz, box: {min: [-1, -1, -1], max: [0, 1, 1]}}]
)";
  Scene scene = parse(yaml);
  const std::string resolved = resolved_yaml(scene);
  const auto has = [&](const std::string& line) {
    EXPECT_NE(resolved.find(line + "\n"), resolved.npos) << line << "\n" << resolved;
  };
  has("    areal_density: 0.187  # kg/m², fabric cotton_interlock, measured");
  has("    thickness: 0.0011  # m");
  has("    membrane: {warp: 68.95, weft: 33.19, shear: 36.86, wet: 1, warp_locking: 0, weft_locking: 0}  # fabric "
      "cotton_interlock, derived");
  has("      diffusivity: 0.000125  # m²/s, fabric cotton_interlock, assumed: of sock_nylon");
  has("      diffusion_exponent: 5  # fabric cotton_interlock, assumed: of sock_nylon");
  has("          diffusivity: 0.000125  # m²/s, fabric denim_11oz, assumed: of sock_nylon");
  EXPECT_TRUE(same_scene(parse(resolved), scene));
  EXPECT_TRUE(same_scene(parse(to_yaml(scene)), scene));
  scene.cloths[0].material.capillary_height = 0.2;  // a program's own value
  EXPECT_NE(resolved_yaml(scene).find("      capillary_height: 0.2  # m\n"), std::string::npos);
}

TEST(Fabrics, AnUnknownNameIsAnsweredWithTheNearestAndTheList) {
  const std::string what = error_of(wet_scene, {"cloth.0.fabric=denim_11os"});
  EXPECT_NE(what.find("cloth.0.fabric: 'denim_11os' is not known; did you mean 'denim_11oz'? allowed: none, "),
            what.npos)
      << what;
  for (const Fabric& f : fabrics()) EXPECT_NE(what.find(", " + f.name), what.npos) << what;
  EXPECT_NE(error_of(wet_scene, {"cloth.0.fabric=3"}).find("'3' is not known; allowed: none"), std::string::npos);
}

/// What a fabric gives is refused where the fabric is named.
TEST(Fabrics, AConflictIsReportedAtTheName) {
  EXPECT_EQ(
      error_of(wet_scene, {"cloth_solver.method=xpbd"}),
      "test.yaml:7:13: cloth.0.bending: cannot be combined with cloth_solver.method: xpbd; allowed: only with pd");
}

TEST(Fabrics, CheckPrintsTheValuesAndHowEachIsKnown) {
  const test::TempFolder folder;
  test::write_text(folder.path() / "wet.yaml", wet_scene);
  const test::Outcome found =
      test::run_drench(folder.path(), {"check", "wet.yaml", "--set", "cloth.0.thickness=0.001"});
  EXPECT_NE(
      found.out.find(
          "fabric cotton_interlock of cloth sheet:\n"
          "  areal_density 0.187 kg/m² = 187 g/m² (measured)\n"
          "  membrane.warp 68.95 N/m, membrane.weft 33.19 N/m, membrane.shear 36.86 N/m, bending.warp 5.8e-06 N·m, "
          "bending.weft 3.57e-06 N·m, bending.twist 7.69e-06 N·m (derived)\n"
          "  porous.solid_fraction 0.228 (similar: fibre of 1464 kg/m3 (60 % cotton and 40 % polyester))\n"
          "  porous.permeability 4.5e-11 m² (similar: K7: 11 Pa, 0.56 mm)\n"
          "  porous.diffusivity 1.25e-4 m²/s, porous.diffusion_exponent 5, porous.capillary_height 0.153 m "
          "(assumed: of sock_nylon)\n"
          "  not used: thickness\n"),
      std::string::npos)
      << found.out << found.err;
  std::string dry = wet_scene;
  dry.erase(dry.find("    porous: {}\n"));
  test::write_text(folder.path() / "dry.yaml", dry);
  EXPECT_NE(test::run_drench(folder.path(), {"check", "dry.yaml"})
                .out.find("warning: cloth sheet absorbs no liquid, although its fabric"),
            std::string::npos);
}

}  // namespace drench::testing
