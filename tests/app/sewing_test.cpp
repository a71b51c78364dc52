// Seams of mesh files: welded, sewn or left open; pieces; units and axes.

#include "setup/sewing.hpp"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>

#include "mesh_folder.hpp"
#include "setup/mesh_guess.hpp"
#include "setup/pieces.hpp"

namespace drench::testing {
namespace {

/// OBJ text of panels, each a sheet of columns × rows cells.
class Obj {
 public:
  /// `place(u, v)`: where a point at u, v of [0, 1] lies. Faces of columns [first, last) are in the group.
  template <class Place>
  Obj& panel(int columns, int rows, Place place, const std::string& group = "", int first = 0, int last = 1000) {
    for (int j = 0; j <= rows; ++j)
      for (int i = 0; i <= columns; ++i) {
        const Vec3 x = place(static_cast<double>(i) / columns, static_cast<double>(j) / rows);
        text_ += "v " + std::to_string(x[0]) + " " + std::to_string(x[1]) + " " + std::to_string(x[2]) + "\n";
      }
    for (int j = 0; j < rows; ++j)
      for (int i = 0; i < columns; ++i) {
        if (!group.empty()) text_ += "g " + (first <= i && i < last ? group : "rest") + "\n";
        const int a = points_ + j * (columns + 1) + i + 1, b = a + 1, c = a + columns + 1, e = c + 1;
        for (const auto& t : {std::array{a, b, e}, std::array{a, e, c}})
          text_ += "f " + std::to_string(t[0]) + " " + std::to_string(t[1]) + " " + std::to_string(t[2]) + "\n";
      }
    points_ += (columns + 1) * (rows + 1);
    return *this;
  }
  const std::string& text() const { return text_; }

 private:
  std::string text_;
  int points_ = 0;
};

class Sewing : public MeshFolder {
 protected:
  /// Of a scene with one cloth, which has these keys besides its mesh, garment.obj.
  drench::Setup set_up(const Obj& obj, const std::string& keys = "", const std::string& mesh = "",
                       const std::string& more = "") const {
    write("garment.obj", obj.text());
    const std::string yaml =
        "drench: 1\n" + more + "cloth:\n  - name: garment\n    mesh: {file: garment.obj" + mesh + "}\n" + keys;
    return built(yaml);
  }
  std::string refusal(const Obj& obj, const std::string& keys) const {
    return refusal_of([&] { set_up(obj, keys); });
  }
};

Vec3 upper(double u, double v) { return {0.4 * u, 0.2 * v, 0}; }
Vec3 lower(double u, double v) { return {0.4 * u, 0.2 * v - 0.2, 0}; }
/// 1 cm below it.
Vec3 apart(double u, double v) { return {0.4 * u, 0.2 * v - 0.21, 0}; }

Obj seam() { return Obj().panel(20, 10, upper).panel(20, 10, lower); }

TEST_F(Sewing, DoubledPointsOfASeamBecomeOneNode) {
  const drench::Setup setup = set_up(seam());
  const ClothMesh& mesh = setup.model.mesh;
  EXPECT_EQ(mesh.nodes(), 2 * 231 - 21);
  EXPECT_EQ(mesh.nodes() - static_cast<Index>(mesh.edge.size()) + mesh.triangles(), 1) << "a disc";
  EXPECT_TRUE(any_has(setup.notes, "cloth 'garment': weld: 21 pairs of boundary points sewn"));
  EXPECT_EQ(pieces_of(setup.model).size(), 1U);
  EXPECT_EQ(set_up(seam(), "    weld: off\n").model.mesh.nodes(), 2 * 231);
}

TEST_F(Sewing, NearlyCoincidentPointsAreWeldedAndFartherOnesAreNot) {
  const auto off_by = [](double gap) {
    return [gap](double u, double v) { return Vec3{0.4 * u, 0.2 * v - 0.2 - gap, 0}; };
  };
  EXPECT_EQ(set_up(Obj().panel(20, 10, upper).panel(20, 10, off_by(1e-5))).model.mesh.nodes(), 2 * 231 - 21);
  const Obj wide = Obj().panel(20, 10, upper).panel(20, 10, off_by(1e-3));
  EXPECT_EQ(set_up(wide).model.mesh.nodes(), 2 * 231);
  const drench::Setup asked = set_up(wide, "    weld: 0.002\n");
  EXPECT_EQ(asked.model.mesh.nodes(), 2 * 231 - 21);
  EXPECT_EQ(pieces_of(asked.model).size(), 1U);
}

TEST_F(Sewing, TheRestOfASeamThatIsWeldedInPartIsReported) {
  const auto opening = [](double u, double v) {
    return Vec3{0.4 * u, 0.2 * v - 0.2 - (v == 1 && u > 0.51 ? 5e-4 : 0), 0};
  };
  const Obj obj = Obj().panel(20, 10, upper).panel(20, 10, opening);
  const auto notes = set_up(obj).notes;
  EXPECT_TRUE(any_has(notes,
                      "11 pairs of boundary points sewn; 10 more pairs, up to 0.0005 m apart, are not sewn; "
                      "weld: 0.0006 sews all pairs that near"));
  const drench::Setup asked = set_up(obj, "    weld: 0.0006\n");
  EXPECT_EQ(asked.model.mesh.nodes(), 2 * 231 - 21);
  EXPECT_FALSE(any_has(asked.notes, "more pairs"));
  EXPECT_FALSE(any_has(set_up(seam()).notes, "more pairs"));
}

TEST_F(Sewing, ADistanceBeyondTheEdgesTakesNoTriangleItsArea) {
  const drench::Setup setup = set_up(seam(), "    weld: 0.03\n");  // edges of 2 cm
  EXPECT_EQ(pieces_of(setup.model).size(), 1U);
  EXPECT_EQ(setup.model.mesh.triangles(), 800);
  for (const auto& t : setup.model.mesh.triangle) EXPECT_TRUE(t[0] != t[1] && t[1] != t[2] && t[2] != t[0]);
}

TEST_F(Sewing, LayersThatLieOnEachOtherAreNotWelded) {
  const Obj layers = Obj().panel(10, 10, upper).panel(10, 10, upper);
  const drench::Setup setup = set_up(layers);
  EXPECT_EQ(setup.model.mesh.nodes(), 2 * 121);
  EXPECT_TRUE(any_has(setup.notes,
                      "weld: no pairs of boundary points sewn; 40 pairs of points of overlapping sheets are not sewn"));
  // a smaller one within a larger one has no boundary point in common with it
  EXPECT_EQ(set_up(Obj()
                       .panel(10, 10, upper)
                       .panel(6, 6,
                              [](double u, double v) {
                                return Vec3{0.08 + 0.24 * u, 0.04 + 0.12 * v, 0};
                              }))
                .model.mesh.nodes(),
            121 + 49);
}

/// Two layers of squares, with points of their own or shared ones; a reversed face is cut along the same diagonal.
TEST_F(Sewing, TwoSidesOfQuadsAreNeitherSewnNorCutApart) {
  constexpr int n = 8;
  for (const bool shared : {false, true})
    for (const double bend : {0.0, 0.03}) {
      std::string text;
      for (int side = 0; side < (shared ? 1 : 2); ++side)
        for (int j = 0; j <= n; ++j)
          for (int i = 0; i <= n; ++i)
            text += fmt::format("v {} {} {}\n", 0.05 * i, 0.05 * j + 0.004 * (i % 3), bend * std::sin(1.0 * i * j));
      for (int side = 0; side < 2; ++side)
        for (int j = 0; j < n; ++j)
          for (int i = 0; i < n; ++i) {
            const int a = (shared ? 0 : side * (n + 1) * (n + 1)) + j * (n + 1) + i + 1, b = a + 1, d = a + n + 1,
                      c = d + 1;
            text += side == 0 ? fmt::format("f {} {} {} {}\n", a, b, c, d) : fmt::format("f {} {} {} {}\n", d, c, b, a);
          }
      write("two.obj", text);
      const drench::Setup setup = built("drench: 1\ncloth: [{name: two, mesh: {file: two.obj}}]\n");
      EXPECT_EQ(setup.model.mesh.nodes(), (shared ? 1 : 2) * (n + 1) * (n + 1));
      EXPECT_EQ(setup.model.mesh.triangles(), (shared ? 1 : 2) * 2 * n * n);
      EXPECT_EQ(any_has(setup.warnings, "triangles of the mesh that repeat an earlier one are omitted: 128"), shared);
      EXPECT_FALSE(setup.model.has_stitches());
    }
  // Layers that are cut along different diagonals lie on each other as well.
  const auto mirrored = [](double u, double v) { return upper(1 - u, v); };
  const drench::Setup crossed = set_up(Obj().panel(10, 10, upper).panel(10, 10, mirrored));
  EXPECT_EQ(crossed.model.mesh.nodes(), 2 * 121);
  EXPECT_TRUE(any_has(crossed.notes, "40 pairs of points of overlapping sheets are not sewn"));
}

TEST_F(Sewing, ThreePanelsMeetInAPointAndAtASeam) {
  // a T: two panels below one; the middle of its lower side is a point of all three
  const auto left = [](double u, double v) { return Vec3{0.2 * u, 0.2 * v - 0.2, 0}; };
  const auto right = [](double u, double v) { return Vec3{0.2 + 0.2 * u, 0.2 * v - 0.2, 0}; };
  const drench::Setup tee = set_up(Obj().panel(20, 10, upper).panel(10, 10, left).panel(10, 10, right));
  EXPECT_EQ(tee.model.mesh.nodes(), 231 + 2 * 121 - 22 - 10);
  EXPECT_EQ(tee.model.mesh.nodes() - static_cast<Index>(tee.model.mesh.edge.size()) + tee.model.mesh.triangles(), 1);
  EXPECT_FALSE(tee.model.has_stitches());
  // a fin on the seam: its edges would have three triangles
  const auto fin = [](double u, double v) { return Vec3{0.4 * u, 0, 0.2 * v}; };
  const drench::Setup three = set_up(Obj().panel(20, 10, upper).panel(20, 10, lower).panel(20, 10, fin));
  EXPECT_EQ(pieces_of(three.model).size(), 1U);
  EXPECT_EQ(static_cast<Index>(three.model.mesh.stitch.size()), three.model.mesh.nodes() - (3 * 231 - 42));
  EXPECT_GE(three.model.mesh.stitch.size(), 10U);
  EXPECT_TRUE(any_has(three.notes, "weld: 42 pairs of boundary points sewn"));
  for (const double end : three.model.mesh.stitch_time) EXPECT_EQ(end, 0);
}

TEST_F(Sewing, PinsKeepTheNumbersOfTheFile) {
  const drench::Setup setup =
      set_up(seam(), "    pin: [{nodes: [231, 461, 3]}]\n");  // the first and the last of the lower panel
  const ClothMesh& mesh = setup.model.mesh;
  std::vector<Vec3> pinned;
  for (std::size_t n = 0; n < mesh.pinned.size(); ++n)
    if (mesh.pinned[n]) pinned.push_back(mesh.rest_position[n]);
  ASSERT_EQ(pinned.size(), 3U);
  EXPECT_NEAR((to_eigen(pinned[0]) - Eigen::Vector3d(0.06, 0, 0)).norm(), 0, 1e-6);
  EXPECT_NEAR((to_eigen(pinned[1]) - Eigen::Vector3d(0.4, 0, 0)).norm(), 0, 1e-6) << "welded to the upper panel's";
  EXPECT_NEAR((to_eigen(pinned[2]) - Eigen::Vector3d(0, -0.2, 0)).norm(), 0, 1e-6);
  EXPECT_NE(refusal(seam(), "    pin: [{nodes: [462]}]\n").find("there is no node 462; allowed: 0 to 461"),
            std::string::npos);
}

TEST_F(Sewing, PiecesAreListedAndLooseOnesWarnedOf) {
  const Obj two = Obj().panel(20, 10, upper).panel(20, 10, apart);
  const std::string pin = "    pin: [{box: {min: [-0.01, 0.19, -0.01], max: [0.41, 0.21, 0.01]}}]\n";
  const drench::Setup setup = set_up(two, pin);
  EXPECT_TRUE(any_has(setup.notes, "2 pieces that are not sewn together"));
  EXPECT_TRUE(any_has(setup.notes, "piece 0: 231 nodes, 0.4 × 0.2 × 0 m, 21 pinned"));
  EXPECT_TRUE(any_has(setup.notes, "piece 1: 231 nodes, 0.4 × 0.2 × 0 m, not pinned"));
  EXPECT_TRUE(any_has(setup.warnings, "nothing holds piece 1 of 2"));
  EXPECT_FALSE(any_has(setup.warnings, "nothing holds piece 0"));
  const std::string floor = "bodies: [{plane: {point: [0, -0.5, 0], normal: [0, 1, 0]}}]\n";
  EXPECT_FALSE(any_has(set_up(two, pin, "", floor).warnings, "nothing holds")) << "it falls on a floor";
  EXPECT_FALSE(any_has(set_up(two, pin + "    sew: [{pairs: [[0, 441]]}]\n").warnings, "nothing holds"));
  EXPECT_TRUE(set_up(seam(), pin).notes.size() == 1);
}

TEST_F(Sewing, StitchesFollowLoopsGroupsPairsAndFiles) {
  const auto left = [](double u, double v) { return Vec3{0.2 * u, 0.2 * v, 0}; };
  const auto right = [](double u, double v) { return Vec3{0.3 + 0.2 * u, 0.2 * v, 0}; };
  const Obj obj = Obj().panel(10, 8, left, "left").panel(10, 12, right, "right");
  const drench::Setup loops = set_up(obj, "    sew: [{loops: [[0, 1]]}]\n");
  EXPECT_EQ(loops_of(loops.model, loops.model.cloths[0]).size(), 2U);
  const ClothMesh& mesh = loops.model.mesh;
  std::vector<int> stitches(static_cast<std::size_t>(mesh.nodes()), 0);
  for (const auto& [a, b] : mesh.stitch) {
    EXPECT_LT(a, 99);
    EXPECT_GE(b, 99);
    ++stitches[static_cast<std::size_t>(a)];
    ++stitches[static_cast<std::size_t>(b)];
  }
  for (std::size_t k = 0; k < mesh.stitch.size(); ++k) {
    EXPECT_EQ(mesh.stitch_time[k], 0.5);
    EXPECT_GT(mesh.stitch_length[k], 0.05);
    EXPECT_EQ(mesh.stitch_stiffness[k], 500);
  }
  for (const Chain& loop : loops_of(loops.model, loops.model.cloths[0]))
    for (const Index n : loop.nodes) EXPECT_GE(stitches[static_cast<std::size_t>(n)], 1) << n;
  EXPECT_EQ(set_up(obj, "    sew: [{groups: [left, right]}]\n").model.mesh.stitch, mesh.stitch);
  write("seams.txt", "# right side of the left panel\n10 99\n21,110 # both\n\n");
  const std::string file = set_up(obj, "    sew: [{file: seams.txt}]\n").model.scene.cloths[0].sew[0].file;
  EXPECT_NE(file.find("seams.txt"), std::string::npos);
  const drench::Setup pairs = set_up(obj, "    sew: [{file: seams.txt}, {pairs: [[99, 10], [0, 1], [5, 5]]}]\n");
  EXPECT_EQ(pairs.model.mesh.stitch, (std::vector<std::array<Index, 2>>{{10, 99}, {21, 110}}));
  EXPECT_TRUE(
      any_has(pairs.notes, "sew: 2 pairs of points get no stitch: they are one node already or have a common edge"));
  EXPECT_FALSE(any_has(loops.notes, "no stitch"));
}

TEST_F(Sewing, AStripOfFacesSewsTheEdgeAlongIt) {
  const auto left = [](double u, double v) { return Vec3{0.2 * u, 0.2 * v + 0.01 * std::sin(6 * u), 0}; };
  const auto right = [](double u, double v) { return Vec3{0.23 + 0.2 * u + 0.01 * v * v, 0.2 * v, 0}; };
  const Obj obj = Obj().panel(10, 8, left, "left", 8).panel(10, 8, right, "right", 0, 2);
  std::vector<std::array<Index, 2>> sides;
  for (Index j = 0; j <= 8; ++j) sides.push_back({10 + 11 * j, 99 + 11 * j});
  EXPECT_EQ(set_up(obj, "    sew: [{groups: [left, right]}]\n").model.mesh.stitch, sides);
  // The boundary of a wider group goes round the panel's corners: all of it is sewn.
  const Obj wide = Obj().panel(10, 8, left, "left", 5).panel(10, 8, right, "right", 0, 5);
  EXPECT_EQ(set_up(wide, "    sew: [{groups: [left, right]}]\n").model.mesh.stitch.size(), 19U);
}

/// Two points of a panel are so near that cleaning makes one of them; a stitch of both is gone, the other stays.
TEST_F(Sewing, AStitchWhoseNodesCleaningMergesIsGone) {
  Obj obj;
  obj.panel(4, 4, [](double u, double v) { return Vec3{u == 0.25 ? 1e-5 : 0.4 * u, 0.4 * v, 0}; });
  const std::string keys = "    clean: 1.0e-4\n    sew: [{pairs: [[10, 11], [4, 20]]}]\n";
  const drench::Setup setup = set_up(obj, keys);
  const ClothMesh& mesh = setup.model.mesh;
  EXPECT_LT(mesh.nodes(), 25);
  ASSERT_EQ(mesh.stitch.size(), 1U);
  EXPECT_NE(mesh.stitch[0][0], mesh.stitch[0][1]);
  for (const Index n : mesh.stitch[0]) EXPECT_LT(n, mesh.nodes());
}

TEST_F(Sewing, RefusesSeamsThatThereAreNot) {
  const Obj obj = seam();
  EXPECT_NE(refusal(obj, "    weld: off\n    sew: [{loops: [[0, 2]]}]\n")
                .find("cloth.0.sew.0: cloth 'garment': sew: there is no boundary loop 2"),
            std::string::npos);
  const std::string group = refusal(obj, "    sew: [{groups: [left, right]}]\n");
  EXPECT_NE(group.find("has no group 'left'"), std::string::npos) << group;
  EXPECT_NE(refusal(obj, "    sew: [{pairs: [[0, 462]]}]\n").find("there is no point 462; allowed: 0 to 461"),
            std::string::npos);
  write("seams.txt", "1 2\n3 x\n");
  EXPECT_NE(refusal(obj, "    sew: [{file: seams.txt}]\n").find("seams.txt', line 2: allowed: two numbers of points"),
            std::string::npos);
}

TEST_F(Sewing, LiquidPassesStitchedNodes) {
  const std::string keys = "    weld: off\n    sew: [{loops: [[0, 1]]}]\n    porous: {diffusivity: 1.0e-4}\n";
  const drench::Setup setup = set_up(seam(), keys);
  std::vector<std::array<Index, 2>> pairs = setup.model.fabric.nodes;
  std::sort(pairs.begin(), pairs.end());
  ASSERT_FALSE(setup.model.mesh.stitch.empty());
  for (const auto& stitch : setup.model.mesh.stitch)
    EXPECT_TRUE(std::binary_search(pairs.begin(), pairs.end(), stitch));
}

TEST_F(Sewing, UnitsAndAxesOfFilesLeadToTheSameMesh) {
  const auto tall = [](double u, double v) { return Vec3{0.3 * u, 0.2 + 0.5 * v, 0.1 * u * u}; };
  const Obj metres = Obj().panel(6, 8, tall);
  const drench::Setup plain = set_up(metres);
  const auto same = [&](const drench::Setup& other, double tolerance) {
    const auto &a = plain.model.mesh.rest_position, &b = other.model.mesh.rest_position;
    ASSERT_EQ(a.size(), b.size());
    for (std::size_t n = 0; n < a.size(); ++n) EXPECT_NEAR((to_eigen(a[n]) - to_eigen(b[n])).norm(), 0, tolerance);
  };
  const auto turned = [&](double unit, auto axes) {
    return Obj().panel(6, 8, [=](double u, double v) {
      const Vec3 x = tall(u, v);
      return axes(x[0] / unit, x[1] / unit, x[2] / unit);
    });
  };
  same(set_up(turned(0.01,
                     [](double x, double y, double z) {
                       return Vec3{x, -z, y};
                     }),
              "", ", unit: cm, up: z"),
       1e-6);
  same(set_up(turned(0.001,
                     [](double x, double y, double z) {
                       return Vec3{y, -x, z};
                     }),
              "", ", unit: mm, up: x"),
       1e-6);
  same(set_up(turned(0.0254, [](double x, double y, double z) { return Vec3{x, y, z}; }), "", ", unit: inch"), 1e-6);
  same(set_up(turned(0.005,
                     [](double x, double y, double z) {
                       return Vec3{x, y, z};
                     }),
              "", ", unit: cm, scale: 0.5"),
       1e-6);
}

TEST_F(Sewing, BodiesHaveUnitsAxesAndAPlace) {
  // an open box is enough to look at its points
  write("body.obj", Obj().panel(2, 2, [](double u, double v) { return Vec3{100 * u, 0, 50 * v}; }).text());
  const std::string keys =
      "bodies:\n  - mesh: {file: body.obj, unit: cm, up: z, position: [0, 0.5, 0]}\n"
      "    place: {position: [1, 0, 0], rotate: {axis: [0, 1, 0], degrees: 90}}\n";
  const drench::Setup setup = set_up(Obj().panel(2, 2, upper), "    dynamics: false\n", "", keys);
  const std::vector<Vec3>& points = setup.model.bodies.at(0).mesh_points;
  const Vec3 last = points.back();  // (1, 0, 0.5) m in the file; upright (1, 0.5, 0); turned (0, 0.5, -1)
  EXPECT_NEAR(last[0], 1, 1e-9);
  EXPECT_NEAR(last[1], 1, 1e-9);
  EXPECT_NEAR(last[2], -1, 1e-9);
}

TEST_F(Sewing, AMeshInAnotherUnitGetsAHint) {
  const Obj centimetres = Obj().panel(6, 8, [](double u, double v) { return Vec3{60 * u, 172 * v, 0}; });
  EXPECT_TRUE(any_has(set_up(centimetres).warnings, "is 172 m tall: if the file is in centimetres, add unit: cm"));
  const Obj millimetres = Obj().panel(6, 8, [](double u, double v) { return Vec3{600 * u, 1720 * v, 0}; });
  EXPECT_TRUE(any_has(set_up(millimetres).warnings, "is 1.72e+03 m tall: if the file is in millimetres, add unit: mm"));
  EXPECT_TRUE(any_has(set_up(Obj().panel(6, 8, upper), "", ", unit: cm").warnings,
                      "if the file is in metres, remove unit: cm"));
  // in place of a message about samples
  const std::string message = refusal(centimetres, "    porous: {}\n    sample_spacing: 0.001\n");
  EXPECT_NE(message.find("172 m tall: if the file is in centimetres, add unit: cm"), std::string::npos) << message;
  for (const std::string& line : set_up(Obj().panel(6, 8, upper)).warnings)
    EXPECT_EQ(line.find("unit"), std::string::npos) << line;
}

TEST(MeshGuess, TellsUpFromTheGroundAndFromTheSides) {
  EXPECT_EQ(guess_of({{-0.2, 0.06, -0.14}, {0.2, 0.56, 0.14}}).up, UpAxis::y);
  const MeshGuess tunic = guess_of({{-20, -14, 6}, {20, 14, 56}});
  EXPECT_EQ(tunic.up, UpAxis::z);
  EXPECT_EQ(tunic.unit, LengthUnit::cm);
  EXPECT_FALSE(tunic.up_reason.empty());
  EXPECT_EQ(guess_of({{-0.85, -1.2, -0.15}, {0.85, 0.5, 0.15}}).up, UpAxis::y) << "a figure with its arms out";
  EXPECT_EQ(guess_of({{-850, -150, 0}, {850, 150, 1750}}).up, UpAxis::z);
  EXPECT_EQ(guess_of({{-850, -150, 0}, {850, 150, 1750}}).unit, LengthUnit::mm);
  EXPECT_EQ(guess_of({{-0.5, -0.3, -0.5}, {0.5, 0.3, 0.5}}).up, UpAxis::y) << "a wide skirt";
  EXPECT_EQ(guess_of({{-0.3, 0, -0.3}, {0.3, 0.001, 0.3}}).up, UpAxis::y) << "a sheet that lies";
}

TEST(MeshGuess, OfABodyKnowsPersonsInDecimetres) {
  EXPECT_EQ(guess_of_body({{-5, -8.3, -1}, {5, 8.4, 1}}).unit, LengthUnit::dm);
  EXPECT_FALSE(guess_of_body({{-5, -8.3, -1}, {5, 8.4, 1}}).unit_reason.empty());
  EXPECT_EQ(guess_of({{-5, -8.3, -1}, {5, 8.4, 1}}).unit, LengthUnit::dm) << "a dress; in cm it would fit a doll";
  EXPECT_EQ(guess_of({{-10, 0, -1}, {10, 25, 1}}).unit, LengthUnit::cm);
  EXPECT_EQ(guess_of_body({{-50, -83, -10}, {50, 84, 10}}).unit, LengthUnit::cm);
  EXPECT_EQ(guess_of_body({{-0.5, -0.83, -0.1}, {0.5, 0.84, 0.1}}).unit, LengthUnit::m);
}

TEST(MeshGuess, FitsAGarmentToItsBody) {
  const Box person{{-0.85, 0, -0.15}, {0.85, 1.75, 0.15}};
  const Box shirt{{-0.4, 0.9, -0.16}, {0.4, 1.5, 0.16}};
  const MeshGuess body = guess_of(person);
  const auto scaled = [](const Box& b, double s) {
    Box out = b;
    for (std::size_t a = 0; a < 3; ++a) {
      out.min[a] *= s;
      out.max[a] *= s;
    }
    return out;
  };
  EXPECT_EQ(guess_beside(shirt, person, body).unit, LengthUnit::m);
  EXPECT_EQ(guess_beside(scaled(shirt, 10), person, body).unit, LengthUnit::dm);
  EXPECT_EQ(guess_beside(scaled(shirt, 100), person, body).unit, LengthUnit::cm);
  EXPECT_EQ(guess_beside(scaled(shirt, 1000), person, body).unit, LengthUnit::mm);
  EXPECT_EQ(guess_beside(scaled(shirt, 1 / 0.0254), person, body).unit, LengthUnit::inch);
  const Box z_up{{-0.4, -0.16, 0.9}, {0.4, 0.16, 1.5}};
  EXPECT_EQ(guess_beside(z_up, person, body).up, UpAxis::z);
  const Box person_z{{-85, -15, 0}, {85, 15, 175}};
  const MeshGuess other = guess_of(person_z);
  EXPECT_EQ(other.up, UpAxis::z);
  EXPECT_EQ(other.unit, LengthUnit::cm);
  EXPECT_EQ(guess_beside(scaled(z_up, 100), person_z, other).up, UpAxis::z);
  EXPECT_EQ(guess_beside(scaled(z_up, 100), person_z, other).unit, LengthUnit::cm);
}

/// A thing that no garment fits: the cloth keeps a size that cloth has.
TEST(MeshGuess, ClothOnSmallThingsIsNoDwarf) {
  const Box duck{{-136, -79, -177}, {136, 219, 177}}, worm{{-0.6, 0, -2.8}, {0.64, 1.04, 2.3}};
  const Box sheet{{-1, 0, -1}, {1, 0, 1}}, sock{{-0.05, 0.01, -0.15}, {0.08, 0.33, 0.14}}, flag{{0, 0, 0}, {3, 2, 0}};
  EXPECT_EQ(guess_beside(sheet, duck, guess_of(duck)).unit, LengthUnit::m);
  EXPECT_EQ(guess_beside(sock, worm, guess_of(worm)).unit, LengthUnit::m);
  EXPECT_EQ(guess_beside(flag, duck, guess_of(duck)).up, guess_of(duck).up) << "a sheet fits around nothing";
}

}  // namespace
}  // namespace drench::testing
