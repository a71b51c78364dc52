// drench new --fabric: a first scene whose cloth is of a named fabric or of one in a file.

#include <fmt/format.h>

#include <filesystem>
#include <string>

#include "commands_fixture.hpp"
#include "scene/fabrics.hpp"
#include "scene/load.hpp"
#include "setup/build.hpp"
#include "setup/first_scene.hpp"

namespace drench::test {
namespace {

class NewSceneOfFabric : public Commands {};

/// A strip of 0.5 m by 0.1 m that stands up, with triangles of this height (m): OBJ text.
std::string strip(double height, bool textured = false) {
  std::string obj;
  const int columns = int(0.1 / height);
  for (int i = 0; i <= columns; ++i)
    for (const int up : {0, 1})
      obj += fmt::format("v {:.9g} {} {:.9g}\nvt {} {}\n", height * i, 0.5 * up, 0.2 * height * i, i, up);
  const auto corner = [&](int k) { return textured ? fmt::format("{0}/{0}", k) : fmt::format("{}", k); };
  for (int k = 1; k < 2 * columns; k += 2)
    obj += fmt::format("f {0} {2} {1}\nf {1} {2} {3}\n", corner(k), corner(k + 1), corner(k + 2), corner(k + 3));
  return obj;
}

TEST_F(NewSceneOfFabric, IsReadyForEachNamedFabric) {
  for (const Fabric& fabric : fabrics()) {
    const FirstScene made = first_scene({.mesh = "", .fabric = fabric.name});
    const Scene scene = parse_scene(made.yaml, "scene.yaml");
    const MaterialScene& cloth = scene.cloths[0].material;
    EXPECT_NE(made.yaml.find("    fabric: " + fabric.name + ' '), std::string::npos);
    for (const FabricValue& v : fabric.values) {
      if (v.key != "thickness") continue;
      EXPECT_EQ(fmt::format("{:g}", cloth.thickness), fmt::format("{:g}", std::stod(v.value)));
    }
    const drench::Setup setup = build(scene);
    const double holds = 0.36 * cloth.thickness * (1 - cloth.solid_fraction) * 1000;  // kg
    EXPECT_NE(made.yaml.find(fmt::format("It holds {:.2g} kg of water", holds)), std::string::npos) << made.yaml;
    EXPECT_GT(setup.model.scene.time.step, 0);
  }
}

TEST_F(NewSceneOfFabric, TakesAFileFromTheFolderOfTheSceneOrByItsPath) {
  write_text(here() / "mine.yaml", "fabric: denim_11oz\nthickness: 0.0012\nporous: {solid_fraction: 0.55}\n");
  const Outcome printed = drench({"new", "--fabric", "mine.yaml"});
  EXPECT_EQ(printed.code, 0) << printed.err;
  EXPECT_NE(printed.out.find("mine.yaml\"   # "), std::string::npos) << printed.out;
  write_text(here() / "scene.yaml", printed.out);
  EXPECT_EQ(drench({"run", "scene.yaml", "--steps", "3", "--quiet", "--no-output"}).code, 0);
  std::filesystem::create_directories(here() / "elsewhere");
  ASSERT_EQ(drench({"new", "--fabric", "mine.yaml", "-o", "elsewhere/scene.yaml"}).code, 0);
  const Scene scene = load_scene((here() / "elsewhere" / "scene.yaml").string());
  EXPECT_EQ(scene.cloths[0].material.thickness, 0.0012);
  EXPECT_EQ(scene.cloths[0].material.solid_fraction, 0.55);
}

TEST_F(NewSceneOfFabric, IsThinnerWhereTrianglesAreTooSmall) {
  write_text(here() / "garment.obj", strip(0.004));
  const Outcome made = drench({"new", "garment.obj", "--fabric", "cotton_terry"});
  EXPECT_EQ(made.code, 0) << made.err;
  write_text(here() / "scene.yaml", made.out);
  const MaterialScene cloth = load_scene((here() / "scene.yaml").string()).cloths[0].material;
  EXPECT_LT(cloth.thickness, 0.0019) << made.out;
  EXPECT_NE(made.out.find("# m; the fabric's is too thick for the smallest triangle"), std::string::npos) << made.out;
}

TEST_F(NewSceneOfFabric, HasAWarpWhereTheFileGivesNone) {
  const auto scene_for = [&](const std::string& obj) {
    write_text(here() / "garment.obj", obj);
    const Outcome made = drench({"new", "garment.obj", "--fabric", "denim_11oz"});
    EXPECT_EQ(made.code, 0) << made.err;
    write_text(here() / "scene.yaml", made.out);
    EXPECT_EQ(drench({"run", "scene.yaml", "--steps", "2", "--quiet", "--no-output"}).code, 0);
    return load_scene((here() / "scene.yaml").string()).cloths[0].material;
  };
  const std::string standing = strip(0.02);
  const MaterialScene upright = scene_for(standing);
  EXPECT_TRUE(upright.has_warp);
  EXPECT_EQ(upright.warp, (Vec3{0, 1, 0}));
  const MaterialScene across = scene_for(standing + "v 0 0.5 0.1\nv 0.02 0.5 0.104\nf 2 4 13\nf 4 14 13\n");
  EXPECT_TRUE(across.has_warp);
  EXPECT_NE(across.warp, (Vec3{0, 1, 0})) << "a part lies";
  EXPECT_FALSE(scene_for(strip(0.02, true)).has_warp);
}

TEST_F(NewSceneOfFabric, ShortensTheStepAlone) {
  const FirstScene shorter = first_scene({.mesh = "", .fabric = "denim_11oz"}, [](const Scene& scene, FilledBodies&) {
    EXPECT_TRUE(scene.cloths[0].material.bending.has_value()) << "a fabric keeps its stiffness";
    return scene.time.step < 0.0011;
  });
  ASSERT_FALSE(shorter.warnings.empty());
  EXPECT_NE(shorter.warnings[0].find(" s the first steps do not converge well; with 0.001 s they do"),
            std::string::npos)
      << shorter.warnings[0];
}

TEST_F(NewSceneOfFabric, NamesWhatIsAllowed) {
  expect_refusal({"new", "--fabric", "denim"}, "there is no fabric 'denim'; did you mean 'denim_11oz'?");
  expect_refusal({"new", "--fabric", "cotton_intrelock"}, "did you mean 'cotton_interlock'?");
  expect_refusal({"new", "--fabric", "polyester"}, "there is no fabric 'polyester'; allowed: ");
  expect_refusal({"new", "--fabric", "nothing.yaml"}, "fabric file 'nothing.yaml': there is no such file");
  expect_refusal({"new", "--fabric", ""}, "--fabric: it has no name");
  std::filesystem::create_directories(here() / "folder.yaml");
  expect_refusal({"new", "--fabric", "folder.yaml"}, "folder.yaml': it is a folder; allowed: a file .yaml or .yml");
  write_text(here() / "canvas.txt", "areal_density: 0.3\n");
  expect_refusal({"new", "--fabric", "canvas.txt"}, "canvas.txt': unknown extension; allowed: a file .yaml or .yml");
  const auto wrong = [&](const std::string& text, const std::string& message) {
    write_text(here() / "wrong.yaml", text);
    expect_refusal({"new", "--fabric", "wrong.yaml"}, message);
  };
  wrong("fabric: [denim_11oz]\n", "wrong.yaml:1:9: fabric: is a list of 1; allowed: a fabric's name or file");
  wrong("fabric:\n", "fabric: is nothing; allowed: a fabric's name or file");
  wrong("porous: 3\n", "wrong.yaml:1:9: porous: is '3'; allowed: a map of keys");
  wrong("about: two words\n", "wrong.yaml:1:1: fabric: gives no values; allowed: fabric, areal_density, ");
  write_text(here() / "wrong.yaml", "thicknes: 1\n");
  expect_refusal({"new", "--fabric", "wrong.yaml"}, "wrong.yaml:1:1: thicknes: is no key of a fabric");
}

}  // namespace
}  // namespace drench::test
