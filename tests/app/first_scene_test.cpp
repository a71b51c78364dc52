// drench new: a first scene for a garment's mesh loads, warns of nothing that it should not, and runs.

#include "setup/first_scene.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <numbers>

#include "commands_fixture.hpp"
#include "scene/load.hpp"
#include "setup/build.hpp"

namespace drench::test {
namespace {

class NewScene : public Commands {
 protected:
  /// A tube with a hem and a neck, as wide as half its height, in `unit` metres: OBJ text.
  static std::string tube(double height, double unit, int around = 24, int rows = 21, double far = 0) {
    std::string obj;
    for (int j = 0; j < rows; ++j)
      for (int i = 0; i < around; ++i) {
        const double angle = 2 * std::numbers::pi * i / around, radius = 0.25 * height;
        obj += fmt::format("v {:.9g} {:.9g} {:.9g}\n", (far + radius * std::cos(angle)) / unit,
                           height * j / (rows - 1) / unit, 0.6 * radius * std::sin(angle) / unit);
      }
    for (int j = 0; j + 1 < rows; ++j)
      for (int i = 0; i < around; ++i) {
        const int a = j * around + i + 1, b = j * around + (i + 1) % around + 1;
        obj += fmt::format("f {} {} {}\nf {} {} {}\n", a, b, a + around, b, b + around, a + around);
      }
    return obj;
  }

  /// An egg that stands in such a tube, is higher, and so wide below it that it holds the tube: OBJ text. `z_up` and in
  /// `unit` metres.
  static std::string figure(double height, double unit = 1, bool z_up = false) {
    constexpr int around = 24, rows = 16;
    std::string obj;
    for (int j = 0; j <= rows; ++j)
      for (int i = 0; i < (j == 0 || j == rows ? 1 : around); ++i) {
        const double angle = 2 * std::numbers::pi * i / around, polar = std::numbers::pi * j / rows;
        const double wide = height * std::sin(polar) * (1 + 5 * std::max(0.0, std::cos(polar) - 0.4));
        const double x = 0.2 * wide * std::cos(angle), y = height * (0.3 - 0.9 * std::cos(polar)),
                     z = 0.12 * wide * std::sin(angle);
        obj += z_up ? fmt::format("v {:.9g} {:.9g} {:.9g}\n", x / unit, -z / unit, y / unit)
                    : fmt::format("v {:.9g} {:.9g} {:.9g}\n", x / unit, y / unit, z / unit);
      }
    const auto at = [](int j, int i) {
      return j == 0 ? 1 : j == rows ? 2 + (rows - 1) * around : 2 + (j - 1) * around + i % around;
    };
    for (int j = 0; j < rows; ++j)
      for (int i = 0; i < around; ++i) {
        if (j > 0) obj += fmt::format("f {} {} {}\n", at(j, i), at(j + 1, i), at(j, i + 1));
        if (j + 1 < rows) obj += fmt::format("f {} {} {}\n", at(j, i + 1), at(j + 1, i), at(j + 1, i + 1));
      }
    return obj;
  }

  /// The scene that `drench new` prints for this mesh, as it stands in scene.yaml after a run of a few steps.
  Scene scene_for(const std::string& obj, const std::string& warning = "") const {
    if (!obj.empty()) write_text(here() / "garment.obj", obj);
    const Outcome made = obj.empty() ? drench({"new"}) : drench({"new", "garment.obj"});
    EXPECT_EQ(made.code, 0) << made.err;
    if (warning.empty())
      EXPECT_EQ(made.err, "");
    else
      EXPECT_NE(made.err.find(warning), std::string::npos) << made.err;
    write_text(here() / "scene.yaml", made.out);
    const Outcome check = drench({"check", "scene.yaml"});
    EXPECT_EQ(check.code, 0) << check.err;
    EXPECT_EQ(check.out.find("warning"), std::string::npos) << check.out;
    const Outcome run = drench({"run", "scene.yaml", "-o", "out", "--overwrite", "--steps", "12", "--quiet"});
    EXPECT_EQ(run.code, 0) << run.err;
    const Table stats = read_table(here() / "out/stats.csv");
    EXPECT_EQ(stats.rows.size(), 12U);
    EXPECT_GT(stats.number(11, "particles"), 10) << "no water";
    EXPECT_EQ(stats.number(11, "mass_error"), 0);
    expect_units(made.out);
    return load_scene((here() / "scene.yaml").string());
  }

  /// Every line with a number has a comment that says why, and a unit or a count.
  static void expect_units(const std::string& yaml) {
    for (const std::string& line : split(yaml, '\n')) {
      const auto hash = line.find('#');
      if (line.substr(0, hash).find_first_of("0123456789") == std::string::npos) continue;
      ASSERT_NE(hash, std::string::npos) << line;
      EXPECT_GT(line.size() - hash, 8U) << line;
    }
  }
};

TEST_F(NewScene, WithoutAMeshIsAPinnedSheet) {
  const Scene scene = scene_for("");
  ASSERT_EQ(scene.cloths.size(), 1U);
  EXPECT_TRUE(scene.cloths[0].grid);
  ASSERT_EQ(scene.cloths[0].pins.size(), 1U);
  EXPECT_EQ(scene.cloths[0].pins[0].kind, PinScene::Kind::edges);
}

TEST_F(NewScene, OfAMetreHangsByItsTopUnderAJetThatMeetsIt) {
  const Scene scene = scene_for(tube(1, 1));
  const ClothScene& cloth = scene.cloths[0];
  EXPECT_EQ(cloth.scale, 1);
  EXPECT_TRUE(cloth.self_collision);
  ASSERT_EQ(cloth.pins.size(), 1U);
  EXPECT_GT(cloth.pins[0].box.min[1], 0.9);
  EXPECT_GE(cloth.pins[0].box.max[1], 1);
  EXPECT_GT(scene.fluid.spacing, 0.0249);  // a fortieth of its size at most, half an edge of 6 cm otherwise
  EXPECT_LT(scene.fluid.spacing, 0.0351);
  const JetScene& jet = scene.fluid.jets.at(0);
  EXPECT_GT(jet.center[1], 1) << "the nozzle is above it";
  // By the law of free fall: where the jet is 6 cm before the axis; the front, 15 cm before it, falls back at first.
  const Vec3& velocity = jet.velocity.plain();
  const double t = (0.06 - jet.center[2]) / velocity[2];
  const double height = jet.center[1] + velocity[1] * t - 0.5 * 9.81 * t * t;
  EXPECT_NEAR(height, 0.45, 0.05);
  for (std::size_t a = 0; a < 3; ++a) {
    EXPECT_LT(scene.domain.min[a], std::min(-0.1, jet.center[a]));
    EXPECT_GT(scene.domain.max[a], jet.center[a] + jet.radius);
  }
}

TEST_F(NewScene, AsSmallAsABunnyHasFinerWaterAndThinnerCloth) {
  const Scene scene = scene_for(tube(0.15, 1, 48, 41));
  EXPECT_EQ(scene.cloths[0].scale, 1);
  EXPECT_LT(scene.fluid.spacing, 0.004);
  EXPECT_GT(scene.fluid.spacing, 0.001 - 1e-9);
  EXPECT_LT(scene.domain.max[1], 0.4);
}

TEST_F(NewScene, OfCentimetresIsScaledAndSaysSo) {
  const Scene scene = scene_for(tube(0.9, 0.01), "90 units long: assumed to be in centimetres");
  EXPECT_EQ(scene.cloths[0].unit, LengthUnit::cm);
  EXPECT_EQ(scene.cloths[0].scale, 1);
  EXPECT_GT(scene.domain.max[1], 0.9);
  EXPECT_LT(scene.domain.max[1], 2);
  EXPECT_NE(read_text(here() / "scene.yaml").find("# garment.obj is 90 units long"), std::string::npos);
}

TEST_F(NewScene, OfMillimetresIsScaledAndSaysSo) {
  EXPECT_EQ(scene_for(tube(0.9, 0.001), "assumed to be in millimetres").cloths[0].unit, LengthUnit::mm);
}

TEST_F(NewScene, OnABodyNeedsNoPinAndTakesUnitsAndAxesOfBoth) {
  write_text(here() / "garment.obj", tube(0.6, 1));
  write_text(here() / "body.obj", figure(0.6));
  const Outcome made = drench({"new", "garment.obj", "--body", "body.obj"});
  ASSERT_EQ(made.code, 0) << made.err;
  EXPECT_NE(made.out.find("# The body is inside the garment and holds it"), std::string::npos) << made.out;
  write_text(here() / "scene.yaml", made.out);
  expect_units(made.out);
  const Scene scene = load_scene((here() / "scene.yaml").string());
  EXPECT_TRUE(scene.cloths[0].pins.empty());
  ASSERT_EQ(scene.bodies.size(), 1U);
  EXPECT_EQ(scene.bodies[0].kind, BodyScene::Kind::mesh);
  EXPECT_EQ(drench({"run", "scene.yaml", "--steps", "3", "--quiet", "--no-output"}).code, 0);

  write_text(here() / "body.obj", figure(0.6, 0.01, true));
  const Outcome mixed = drench({"new", "garment.obj", "--body", "body.obj"});
  ASSERT_EQ(mixed.code, 0) << mixed.err;
  write_text(here() / "scene.yaml", mixed.out);
  const Scene other = load_scene((here() / "scene.yaml").string());
  EXPECT_EQ(other.bodies[0].unit, LengthUnit::cm);
  EXPECT_EQ(other.bodies[0].up, UpAxis::z);
  EXPECT_EQ(other.cloths[0].unit, LengthUnit::m);
  EXPECT_EQ(other.cloths[0].up, UpAxis::y);
  EXPECT_TRUE(other.cloths[0].pins.empty());
}

TEST_F(NewScene, SaysWhereGarmentAndBodyDoNotBelongTogether) {
  write_text(here() / "garment.obj", tube(0.6, 1));
  write_text(here() / "body.obj", figure(0.6));
  const auto of = [&](const char* mesh, const char* body) { return drench({"new", mesh, "--body", body}); };
  const Outcome same = of("body.obj", "./body.obj");
  EXPECT_EQ(same.code, 2);
  EXPECT_NE(same.err.find("it is the garment's file too"), std::string::npos) << same.err;
  EXPECT_EQ(drench({"new", ""}).code, 2);
  EXPECT_EQ(of("garment.obj", "").code, 2);
  const Outcome interchanged = of("body.obj", "garment.obj");
  EXPECT_NE(interchanged.err.find("is closed; if it is the body, interchange the files"), std::string::npos)
      << interchanged.err;
  const Outcome mesh = drench({"check", "garment.obj"});
  EXPECT_EQ(mesh.code, 2);
  EXPECT_NE(mesh.err.find("is a mesh, not a scene"), std::string::npos) << mesh.err;
}

TEST_F(NewScene, OnAnAnimatedBodyFollowsItsFiles) {
  write_text(here() / "garment.obj", tube(0.6, 1));
  for (const char* name : {"body_0.obj", "body_1.obj", "body_2.obj"}) write_text(here() / name, figure(0.6));
  const Outcome made = drench({"new", "garment.obj", "--body", "body_*.obj"});
  ASSERT_EQ(made.code, 0) << made.err;
  write_text(here() / "scene.yaml", made.out);
  const Scene scene = load_scene((here() / "scene.yaml").string());
  ASSERT_EQ(scene.bodies.size(), 1U);
  EXPECT_EQ(scene.bodies[0].sequence.files.size(), 3U);
  EXPECT_EQ(scene.bodies[0].sequence.fps, 24);
  EXPECT_TRUE(scene.cloths[0].pins.empty());
  const Outcome none = drench({"new", "garment.obj", "--body", "figure_*.obj"});
  EXPECT_EQ(none.code, 2);
  EXPECT_NE(none.err.find("mesh files 'figure_*.obj': no such files"), std::string::npos) << none.err;
}

/// A box: OBJ text.
std::string block(const Vec3& min, const Vec3& max) {
  std::string obj;
  for (int corner = 0; corner < 8; ++corner)
    obj += fmt::format("v {} {} {}\n", (corner & 1 ? max : min)[0], (corner & 2 ? max : min)[1],
                       (corner & 4 ? max : min)[2]);
  return obj + "f 1 3 4 2\nf 5 6 8 7\nf 1 2 6 5\nf 3 7 8 4\nf 1 5 7 3\nf 2 4 8 6\n";
}

TEST_F(NewScene, IsPutOnABodyWhoseFileHasAnotherOrigin) {
  write_text(here() / "garment.obj", tube(0.6, 1));
  write_text(here() / "body.obj", figure(0.6));
  EXPECT_EQ(drench({"new", "garment.obj", "--body", "body.obj"}).out.find("    place: "), std::string::npos);
  write_text(here() / "far.obj", tube(0.6, 0.01, 24, 21, 12.347));
  const Outcome made = drench({"new", "far.obj", "--body", "body.obj", "-o", "scene.yaml"});
  ASSERT_EQ(made.code, 0) << made.err;
  EXPECT_EQ(made.out, "");
  const std::string text = read_text(here() / "scene.yaml");
  EXPECT_NE(text.find("# The body is inside the garment and holds it"), std::string::npos) << text;
  EXPECT_NE(text.find("# The garment and the body have different origins: moved by ["), std::string::npos) << text;
  EXPECT_NE(text.find("   # m; moves it onto the body"), std::string::npos) << text;
  expect_units(text);
  const Scene scene = load_scene((here() / "scene.yaml").string());
  const ClothScene& cloth = scene.cloths.at(0);
  EXPECT_EQ(cloth.unit, LengthUnit::cm);
  EXPECT_NEAR(cloth.position[0], -12.347, 0.01);  // the body is 3 cm narrower than the tube
  EXPECT_NEAR(cloth.position[2], 0, 0.01);
  EXPECT_TRUE(cloth.pins.empty());
  EXPECT_EQ(drench({"run", "scene.yaml", "--steps", "3", "--quiet", "--no-output"}).code, 0);
}

/// A skirt whose file has y up and its origin in its middle: by the boxes z is up, as in the body's file.
TEST_F(NewScene, IsTurnedSoThatTheBodyWearsIt) {
  write_text(here() / "body.obj", block({-0.15, -0.11, 0}, {0.15, 0.11, 1.7}));  // z up
  std::string skirt;
  constexpr int around = 24, rows = 9;
  for (int j = 0; j < rows; ++j)
    for (int i = 0; i < around; ++i) {
      const double angle = 2 * std::numbers::pi * i / around, radius = 0.3 - 0.1 * j / (rows - 1.0);
      skirt += fmt::format("v {:.9g} {:.9g} {:.9g}\n", radius * std::cos(angle), -0.125 + 0.25 * j / (rows - 1.0),
                           radius * std::sin(angle));
    }
  for (int j = 0; j + 1 < rows; ++j)
    for (int i = 0; i < around; ++i) {
      const int a = j * around + i + 1, b = j * around + (i + 1) % around + 1;
      skirt += fmt::format("f {} {} {}\nf {} {} {}\n", a, b, a + around, b, b + around, a + around);
    }
  write_text(here() / "garment.obj", skirt);
  const Outcome made = drench({"new", "garment.obj", "--body", "body.obj", "-o", "scene.yaml"});
  ASSERT_EQ(made.code, 0) << made.err;
  const Scene scene = load_scene((here() / "scene.yaml").string());
  EXPECT_EQ(scene.bodies[0].up, UpAxis::z);
  EXPECT_EQ(scene.cloths[0].up, UpAxis::y) << read_text(here() / "scene.yaml");
  EXPECT_NE(read_text(here() / "scene.yaml").find("# The body wears the garment with y up in its file, not z"),
            std::string::npos);
}

TEST_F(NewScene, SewsSeamsThatAreALittleOpen) {
  std::string tubes = tube(0.6, 1), seam;
  // Cut open along one line: the points of its first row are there twice, 1 mm apart; its edges are 3 to 4 cm long.
  constexpr int around = 24, rows = 21;
  for (int j = 0; j < rows; ++j)
    seam += fmt::format("v {:.9g} {:.9g} {:.9g}\n", 0.15 + (j % 2 == 0 ? 0 : 0.001), 0.6 * j / (rows - 1.0), 0.0);
  const std::size_t faces = tubes.find("f ");
  std::string cut = tubes.substr(0, faces) + seam;
  for (int j = 0; j + 1 < rows; ++j)
    for (int i = 0; i < around; ++i) {
      const auto at = [&](int row, int k) { return k == around ? around * rows + row + 1 : row * around + k + 1; };
      cut += fmt::format("f {} {} {}\nf {} {} {}\n", at(j, i), at(j, i + 1), at(j + 1, i), at(j, i + 1),
                         at(j + 1, i + 1), at(j + 1, i));
    }
  write_text(here() / "garment.obj", cut);
  const Outcome made = drench({"new", "garment.obj"});
  ASSERT_EQ(made.code, 0) << made.err;
  EXPECT_NE(made.out.find("    weld: 0.0012"), std::string::npos) << made.out;
  EXPECT_NE(made.out.find("sews 10 pairs of boundary points more than the default"), std::string::npos) << made.out;
  write_text(here() / "scene.yaml", made.out);
  EXPECT_NE(drench({"check", "scene.yaml"}).out.find("boundary loop 1 of "), std::string::npos);
  EXPECT_EQ(drench({"check", "scene.yaml"}).out.find("boundary loop 2 of "), std::string::npos);
}

/// A skirt of four gores, `gap` m apart along all of their seams.
std::string gores(double gap) {
  constexpr int columns = 12, rows = 20;
  std::string points, faces;
  for (int gore = 0; gore < 4; ++gore)
    for (int j = 0; j <= rows; ++j)
      for (int i = 0; i <= columns; ++i) {
        const double angle = 0.5 * std::numbers::pi * gore + (0.5 * std::numbers::pi - gap / 0.15) * i / columns;
        points += fmt::format("v {:.9g} {:.9g} {:.9g}\n", 0.15 * std::cos(angle), 0.025 * j, 0.15 * std::sin(angle));
        if (i == columns || j == rows) continue;
        const int a = (gore * (rows + 1) + j) * (columns + 1) + i + 1, b = a + columns + 1;
        faces += fmt::format("f {} {} {}\nf {} {} {}\n", a, b, a + 1, a + 1, b, b + 1);
      }
  return points + faces;
}

TEST_F(NewScene, SewsSeamsThatAreOpenAllAlong) {
  write_text(here() / "gores.obj", gores(3.9e-4));
  const Outcome made = drench({"new", "gores.obj"});
  ASSERT_EQ(made.code, 0) << made.err;
  EXPECT_NE(made.out.find("    weld: 0.00047"), std::string::npos) << made.out;
  EXPECT_NE(made.out.find("sews 84 pairs of boundary points more than the default"), std::string::npos) << made.out;
  write_text(here() / "scene.yaml", made.out);
  EXPECT_EQ(drench({"check", "scene.yaml"}).out.find("pieces"), std::string::npos);
  std::string without = made.out;
  const std::size_t line = without.find("    weld: ");
  write_text(here() / "open.yaml", without.erase(line, without.find('\n', line) + 1 - line));
  const std::string checked = drench({"check", "open.yaml"}).out;
  EXPECT_NE(checked.find("weld: no pairs of boundary points sewn; 84 pairs, up to 0.00039 m apart, are not sewn; weld: "
                         "0.00047 sews all pairs that near"),
            std::string::npos)
      << checked;
}

/// Wider than a tenth of the edges: what the body holds as long as it is sewn.
TEST_F(NewScene, WarnsOfPiecesThatTheBodyMayNotHold) {
  write_text(here() / "body.obj", tube(0.61, 1));  // radii of 0.153 and 0.092 m
  write_text(here() / "gores.obj", gores(3e-3));
  const Outcome apart = drench({"new", "gores.obj", "--body", "body.obj"});
  ASSERT_EQ(apart.code, 0) << apart.err;
  EXPECT_NE(apart.err.find("the garment is in 4 pieces that are not sewn together, and none of them goes around"),
            std::string::npos)
      << apart.err << apart.out;
  write_text(here() / "gores.obj", gores(3.9e-4));
  EXPECT_EQ(drench({"new", "gores.obj", "--body", "body.obj"}).err.find("pieces"), std::string::npos);
}

TEST_F(NewScene, WritesNewFilesOnly) {
  write_text(here() / "scene.yaml", "drench: 1\n");
  const Outcome again = drench({"new", "-o", "scene.yaml"});
  EXPECT_EQ(again.code, 2);
  EXPECT_EQ(again.err, "drench: scene.yaml: exists; choose another file with -o\n");
  const Outcome nowhere = drench({"new", "-o", "none/scene.yaml"});
  EXPECT_EQ(nowhere.code, 2);
  EXPECT_NE(nowhere.err.find("none: no such folder"), std::string::npos) << nowhere.err;
}

TEST_F(NewScene, BesideABodyThatItDoesNotFitHangsByItsTop) {
  write_text(here() / "garment.obj", tube(0.6, 1, 24, 21, 1));
  write_text(here() / "body.obj", block({-0.4, 0, -0.4}, {0.4, 1, 0.4}));
  const Outcome made = drench({"new", "garment.obj", "--body", "body.obj"});
  ASSERT_EQ(made.code, 0) << made.err;
  EXPECT_NE(made.out.find("# No part of the body is inside the garment"), std::string::npos) << made.out;
  EXPECT_NE(made.out.find("    pin: "), std::string::npos);
  EXPECT_EQ(made.out.find("    place: "), std::string::npos);
}

/// A square sheet in the plane y = height, in cells: OBJ text.
std::string flat_sheet(double side, double height, int cells = 16) {
  std::string obj;
  for (int j = 0; j <= cells; ++j)
    for (int i = 0; i <= cells; ++i)
      obj += fmt::format("v {:.9g} {:.9g} {:.9g}\n", side * (1.0 * i / cells - 0.5), height,
                         side * (1.0 * j / cells - 0.5));
  for (int j = 0; j < cells; ++j)
    for (int i = 0; i < cells; ++i) {
      const int a = j * (cells + 1) + i + 1;
      obj += fmt::format("f {} {} {} {}\n", a, a + cells + 1, a + cells + 2, a + 1);
    }
  return obj;
}

TEST_F(NewScene, OfASheetAndABodyTellsWhetherItFalls) {
  write_text(here() / "sheet.obj", flat_sheet(0.4, 0));
  // One that stands on the sheet, face to face: it does not hold the sheet, and its depth there is rounding.
  write_text(here() / "above.obj", block({-0.075, 0, -0.075}, {0.075, 0.3, 0.075}));
  const Outcome above = drench({"new", "sheet.obj", "--body", "above.obj"});
  ASSERT_EQ(above.code, 0) << above.err;
  EXPECT_NE(above.out.find("# The body is not under the cloth, which would fall past it, so it is pinned at its edges"),
            std::string::npos)
      << above.out;
  EXPECT_NE(above.out.find("    pin: [{edges: true}]"), std::string::npos) << above.out;
  EXPECT_EQ(above.err.find("inside a solid body"), std::string::npos) << above.err;
  // One under it.
  write_text(here() / "below.obj", block({-0.075, -0.2, -0.075}, {0.075, -0.05, 0.075}));
  const Outcome below = drench({"new", "sheet.obj", "--body", "below.obj"});
  ASSERT_EQ(below.code, 0) << below.err;
  EXPECT_NE(below.out.find("# The cloth falls onto the body, so there are no pins"), std::string::npos) << below.out;
  EXPECT_EQ(below.out.find("    pin: "), std::string::npos) << below.out;
  EXPECT_EQ(below.err.find("falls out of the domain"), std::string::npos) << below.err;
}

TEST_F(NewScene, AroundABodyThatDoesNotHoldItIsPinned) {
  write_text(here() / "garment.obj", tube(0.6, 1));
  write_text(here() / "body.obj", block({-0.03, 0.05, -0.03}, {0.03, 0.5, 0.03}));
  const Outcome made = drench({"new", "garment.obj", "--body", "body.obj"});
  ASSERT_EQ(made.code, 0) << made.err;
  EXPECT_NE(made.out.find("# The body is inside the garment but does not hold it, so it is pinned at its highest"),
            std::string::npos)
      << made.out;
  EXPECT_NE(made.out.find("    pin: "), std::string::npos);
  EXPECT_EQ(made.err.find("it falls"), std::string::npos) << made.err;
}

TEST_F(NewScene, PutsItsEmitterBesideABodyThatIsInTheWay) {
  write_text(here() / "sheet.obj", flat_sheet(0.4, 0));
  write_text(here() / "body.obj", block({-0.03, -0.05, -0.03}, {0.03, 0.3, 0.03}));
  const Outcome made = drench({"new", "sheet.obj", "--body", "body.obj"});
  ASSERT_EQ(made.code, 0) << made.err;
  EXPECT_EQ(made.err.find("points of its mouth are inside a solid body"), std::string::npos) << made.err;
}

TEST_F(NewScene, WritesPathsThatHoldInAnotherFolder) {
  write_text(here() / "garment.obj", tube(1, 1));
  std::filesystem::create_directories(here() / "sub");
  const std::string command =
      fmt::format("cd '{}' && '{}' new garment.obj > sub/scene.yaml 2> sub/err.txt", here().string(), program());
  ASSERT_EQ(std::system(command.c_str()), 0) << read_text(here() / "sub/err.txt");
  EXPECT_EQ(drench({"check", "sub/scene.yaml"}).code, 0);
  EXPECT_NE(read_text(here() / "sub/scene.yaml").find("   # absolute path"), std::string::npos);
}

TEST_F(NewScene, SaysWhatItFoundOfSeamsAndPieces) {
  std::string obj;  // two squares with doubled points between them, and one that lies apart
  for (const double x : {0.0, 0.5, 2.0})
    for (int j = 0; j <= 10; ++j)
      for (int i = 0; i <= 10; ++i) obj += fmt::format("v {} {} 0\n", x + 0.05 * i, 0.05 * j);
  for (int panel = 0; panel < 3; ++panel)
    for (int j = 0; j < 10; ++j)
      for (int i = 0; i < 10; ++i) {
        const int a = 121 * panel + 11 * j + i + 1;
        obj += fmt::format("f {} {} {}\nf {} {} {}\n", a, a + 1, a + 12, a, a + 12, a + 11);
      }
  write_text(here() / "garment.obj", obj);
  const Outcome made = drench({"new", "garment.obj"});
  EXPECT_EQ(made.code, 0) << made.err;
  EXPECT_NE(made.out.find("# cloth 'garment': weld: 11 pairs of boundary points sewn.\n"), std::string::npos)
      << made.out;
  EXPECT_NE(made.out.find("# cloth 'garment': 2 pieces that are not sewn together.\n"), std::string::npos) << made.out;
}

TEST_F(NewScene, ShortensTheStepOrSoftensTheFabricUntilATrialConverges) {
  const std::string mesh = (here() / "garment.obj").string();
  write_text(mesh, tube(1, 1));
  int trials = 0;
  const FirstScene shorter = first_scene({.mesh = mesh}, [&](const Scene& scene, FilledBodies&) {
    ++trials;
    return scene.time.step < 0.0011;
  });
  const Scene half = parse_scene(shorter.yaml, "scene.yaml");
  EXPECT_EQ(half.time.step, 0.001);
  EXPECT_EQ(half.cloths[0].material.bend, 1e-4);
  EXPECT_EQ(trials, 4);
  ASSERT_FALSE(shorter.warnings.empty());
  EXPECT_NE(shorter.warnings[0].find(
                "With a step of 0.004 s and bend 0.0001 the first steps do not converge well; with 0.001 s"),
            std::string::npos)
      << shorter.warnings[0];
  const FirstScene softer = first_scene(
      {.mesh = mesh}, [](const Scene& scene, FilledBodies&) { return scene.cloths[0].material.bend < 2e-5; });
  EXPECT_EQ(parse_scene(softer.yaml, "scene.yaml").cloths[0].material.bend, 1e-5);
  trials = 0;
  const FirstScene never = first_scene({.mesh = mesh}, [&](const Scene&, FilledBodies&) {
    ++trials;
    return false;
  });
  EXPECT_EQ(trials, 3) << "the suggestion, the shortest step and the limpest fabric";
  EXPECT_EQ(parse_scene(never.yaml, "scene.yaml").time.step, 0.004);
  EXPECT_NE(never.warnings[0].find("do not converge well, not even with a time.step of 0.00025 s"), std::string::npos)
      << never.warnings[0];
}

TEST_F(NewScene, BringsNodesOutOfABodySlowlyWhereStepsAreShort) {
  const std::string mesh = (here() / "garment.obj").string(), body = (here() / "body.obj").string();
  write_text(mesh, tube(0.6, 1));
  write_text(body, block({-0.18, 0.2, -0.05}, {0.18, 0.4, 0.05}));
  for (const double step : {0.004, 0.0005}) {
    int tried = 0;  // settle of the last trial
    const FirstScene made = first_scene({.mesh = mesh, .body = body}, [&](const Scene& scene, FilledBodies&) {
      tried = scene.cloths[0].settle;
      return scene.time.step <= step;
    });
    const Scene scene = parse_scene(made.yaml, "scene.yaml");
    ASSERT_EQ(scene.time.step, step);
    EXPECT_EQ(scene.cloths[0].settle == ClothScene{}.settle, step == 0.004) << scene.cloths[0].settle;
    EXPECT_EQ(scene.cloths[0].settle, tried) << "what was tried is what runs";
    const drench::Setup setup = build(scene);
    EXPECT_GT(setup.deepest_inside, 0.02) << "m";
    EXPECT_LE(setup.model.cloths[0].release, 0.25) << "m/s";
    expect_units(made.yaml);
  }
}

TEST_F(NewScene, FarFromTheOriginIsBroughtThere) {
  const Scene scene = scene_for(tube(1, 1, 24, 21, 40));
  EXPECT_NEAR(scene.cloths[0].position[0], -40, 0.01);
}

TEST_F(NewScene, WithSliversWarnsAndRuns) {
  const std::string obj = tube(1, 1) + "v 0.5 1 0\nv 0.6 1 0\nv 0.55 1.000005 0\nf -3 -2 -1\n";
  write_text(here() / "garment.obj", obj);
  const Outcome made = drench({"new", "garment.obj"});
  EXPECT_EQ(made.code, 0) << made.err;
  EXPECT_NE(made.err.find("self_collision is off"), std::string::npos) << made.err;
  write_text(here() / "scene.yaml", made.out);
  EXPECT_EQ(drench({"run", "scene.yaml", "--steps", "5", "--quiet", "--no-output"}).code, 0);
}

TEST_F(NewScene, RefusesWhatIsNoClothInOneLine) {
  expect_refusal({"new", "nothing.obj"}, "nothing.obj': no such file");
  write_text(here() / "empty.obj", "v 0 0 0\n");
  expect_refusal({"new", "empty.obj"}, "it holds no triangles");
  write_text(here() / "line.obj", "v 0 0 0\nv 1 0 0\nv 0.5 0 0\nf 1 2 3\n");
  expect_refusal({"new", "line.obj"}, "it holds no triangles");
  write_text(here() / "garment.txt", "v 0 0 0\n");
  expect_refusal({"new", "garment.txt"}, "unknown extension; allowed: .obj, .ply, .stl, .usd");
  std::filesystem::create_directories(here() / "folder");
  expect_refusal({"new", "folder"}, "folder': it is a folder; allowed: a file .obj, .ply or .stl");
  expect_refusal({"new", "a.obj", "b.obj"}, "b.obj");
}

TEST_F(NewScene, OfAnUnknownUnitNamesTheKeyOfAScene) {
  write_text(here() / "body.obj", tube(1.7, 1));
  for (const double unit : {1e3, 1e-6}) {  // kilometres, micrometres
    write_text(here() / "garment.obj", tube(0.6, unit));
    for (const std::string& body : {std::string(), std::string("body.obj")}) {
      std::vector<std::string> words{"new", "garment.obj"};
      if (!body.empty()) words.insert(words.end(), {"--body", body});
      expect_refusal(words, "is no usual size in m, dm, cm, mm or inch");
      expect_refusal(words, fmt::format("write mesh: {{file: …, scale: {:g}}} into the scene", unit));
    }
  }
}

}  // namespace
}  // namespace drench::test
