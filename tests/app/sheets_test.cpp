// Cloth whose mesh is no manifold: repeated triangles, and edges with more than two.

#include "setup/sheets.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "mesh_folder.hpp"
#include "setup/pieces.hpp"

namespace drench::testing {
namespace {

/// Edges with more than two triangles.
Index crowded_edges(const SurfaceMesh& mesh) {
  Index count = 0;
  for (const MeshEdge& e : mesh_edges(mesh.triangles)) count += e.triangles > 2;
  return count;
}

/// Rectangles of `columns` × 1 cells that share their first edge: `wings` of them about the z axis.
SurfaceMesh book(int wings, int columns, int rows) {
  SurfaceMesh mesh;
  for (int j = 0; j <= rows; ++j) mesh.points.push_back({0, 0, 0.1 * j});
  for (int w = 0; w < wings; ++w) {
    const double angle = 0.3 + 2 * w;
    std::vector<Index> before, now;
    for (int j = 0; j <= rows; ++j) before.push_back(j);
    for (int i = 1; i <= columns; ++i) {
      now.clear();
      for (int j = 0; j <= rows; ++j) {
        now.push_back(static_cast<Index>(mesh.points.size()));
        mesh.points.push_back({0.1 * i * std::cos(angle), 0.1 * i * std::sin(angle), 0.1 * j});
      }
      for (std::size_t j = 0; j < static_cast<std::size_t>(rows); ++j) {
        mesh.triangles.push_back({before[j], now[j], now[j + 1]});
        mesh.triangles.push_back({before[j], now[j + 1], before[j + 1]});
      }
      before = now;
    }
  }
  return mesh;
}

/// Four triangles about an edge inside a sheet: fans go from sheet to sheet about both of its ends.
SurfaceMesh fin() {
  return {{{0, 0, 0}, {1, 0, 0}, {0.5, 0, 1}, {0.5, 0, -1}, {0.5, 1, 0}, {-1, 0, 0}, {2, 0, 0}},
          {{0, 1, 2},
           {0, 3, 1},
           {0, 1, 4},  // the fin
           {0, 2, 5},
           {0, 5, 3},
           {1, 6, 2},
           {1, 3, 6},
           {0, 4, 5},  // from the fin to the sheet about one end
           {1, 6, 4}}};
}

TEST(SplitSheets, LeavesAManifoldAsItIs) {
  SurfaceMesh mesh = book(2, 3, 4);
  const SurfaceMesh before = mesh;
  EXPECT_FALSE(split_sheets(mesh).found());
  EXPECT_EQ(mesh.points, before.points);
  EXPECT_EQ(mesh.triangles, before.triangles);
}

TEST(SplitSheets, HoldsSheetsTogetherWhereTheyWereOne) {
  for (const int wings : {3, 4, 5}) {
    SurfaceMesh mesh = book(wings, 3, 4);
    const std::size_t points = mesh.points.size(), triangles = mesh.triangles.size();
    ASSERT_EQ(crowded_edges(mesh), 4);
    const SheetSplit split = split_sheets(mesh);
    const std::size_t sheets = static_cast<std::size_t>(wings + 1) / 2;  // two wings each
    EXPECT_EQ(split.edges, 4);
    EXPECT_EQ(split.repeated, 0);
    EXPECT_EQ(crowded_edges(mesh), 0);
    EXPECT_EQ(mesh.triangles.size(), triangles);
    EXPECT_EQ(mesh.points.size(), points + 5 * (sheets - 1));
    EXPECT_EQ(split.copy_of.size(), 5 * (sheets - 1));
    EXPECT_EQ(split.held.size(), split.copy_of.size());
    for (const auto& [a, b] : split.held) {
      EXPECT_LT(at(a), points);
      EXPECT_EQ(mesh.points[at(a)], mesh.points[at(b)]);
      EXPECT_EQ(split.copy_of[at(b) - points], a);
    }
  }
}

/// Of three wings, those two stay joined that make the larger angle with each other.
TEST(SplitSheets, TheFlattestPairStaysJoined) {
  SurfaceMesh mesh{{{0, 0, 0}, {0, 0, 1}, {1, 0, 0}, {0, 1, 0}, {-1, 0.1, 0}}, {{0, 1, 3}, {0, 1, 2}, {1, 0, 4}}};
  split_sheets(mesh);
  EXPECT_EQ(mesh.triangles[1][0], mesh.triangles[2][1]);
  EXPECT_EQ(mesh.triangles[1][1], mesh.triangles[2][0]);
  EXPECT_NE(mesh.triangles[0][0], mesh.triangles[1][0]);
  EXPECT_NE(mesh.triangles[0][1], mesh.triangles[1][1]);
}

TEST(SplitSheets, CutsLooseWhatFansJoinAboutBothEnds) {
  SurfaceMesh mesh = fin();
  ASSERT_GT(crowded_edges(mesh), 0);
  const std::size_t triangles = mesh.triangles.size();
  const SheetSplit split = split_sheets(mesh);
  EXPECT_EQ(crowded_edges(mesh), 0);
  EXPECT_EQ(mesh.triangles.size(), triangles);
  for (const auto& [a, b] : split.held) EXPECT_EQ(mesh.points[at(a)], mesh.points[at(b)]);
}

TEST(SplitSheets, OmitsRepeatedTrianglesWithTheirTextureAndGroups) {
  SurfaceMesh mesh = book(1, 1, 2);  // four triangles
  mesh.triangles.insert(mesh.triangles.begin() + 1, {mesh.triangles[0][1], mesh.triangles[0][0], mesh.triangles[0][2]});
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) mesh.texture.push_back({{{double(t), 0}, {0, 0}, {0, 0}}});
  mesh.groups = {{"all", {0, 1, 2, 3, 4}}, {"back", {1}}};
  const SheetSplit split = split_sheets(mesh);
  EXPECT_EQ(split.repeated, 1);
  EXPECT_EQ(mesh.triangles.size(), 4U);
  ASSERT_EQ(mesh.texture.size(), 4U);
  EXPECT_EQ(mesh.texture[1][0][0], 2);
  EXPECT_EQ(mesh.groups["all"], (std::vector<Index>{0, 1, 2, 3}));
  EXPECT_TRUE(mesh.groups["back"].empty());
}

class Sheets : public MeshFolder {
 protected:
  static std::string obj_of(const SurfaceMesh& mesh) {
    std::string text;
    for (const Vec3& x : mesh.points)
      text += "v " + std::to_string(x[0]) + " " + std::to_string(x[1]) + " " + std::to_string(x[2]) + "\n";
    for (const auto& t : mesh.triangles)
      text += "f " + std::to_string(t[0] + 1) + " " + std::to_string(t[1] + 1) + " " + std::to_string(t[2] + 1) + "\n";
    return text;
  }
  drench::Setup set_up(const SurfaceMesh& mesh, const std::string& keys = "") const {
    write("garment.obj", obj_of(mesh));
    return built("drench: 1\ncloth:\n  - name: garment\n    mesh: {file: garment.obj}\n" + keys);
  }
};

/// A pocket: three sheets at one seam. It stays on, with and without weld.
TEST_F(Sheets, ThreeSheetsAtASeamStayTogether) {
  for (const char* keys : {"", "    weld: off\n", "    weld: 1.0e-4\n"}) {
    const drench::Setup setup = set_up(book(3, 3, 4), keys);
    EXPECT_TRUE(any_has(setup.warnings, "edges of the mesh with more than two triangles: 4")) << keys;
    EXPECT_EQ(setup.model.mesh.stitch.size(), 5U) << keys;
    EXPECT_EQ(pieces_of(setup.model).size(), 1U) << keys;
  }
}

/// The seam's points are on no border, though the third sheet ends there; its ends are on the border of all sheets.
TEST_F(Sheets, ASeamIsNoBorder) {
  const drench::Setup setup = set_up(book(3, 3, 4), "    pin: [{edges: true}]\n");
  const ClothMesh& mesh = setup.model.mesh;
  int pinned = 0;
  for (Index n = 0; n < mesh.nodes(); ++n) {
    const Vec3& x = mesh.rest_position[at(n)];
    const bool inside = x[2] > 0.01 && x[2] < 0.39, at_seam = std::hypot(x[0], x[1]) < 0.01;
    if (at_seam && inside) {
      EXPECT_FALSE(mesh.pinned[at(n)]) << n;
    }
    pinned += mesh.pinned[at(n)];
  }
  EXPECT_GE(pinned, 3 * (5 + 2 * 2) + 1);
}

/// Copies of one point are never welded to each other, nor counted as layers.
TEST_F(Sheets, WeldLeavesCopiesApart) {
  for (const int wings : {3, 4, 5, 6, 7}) {
    const drench::Setup setup = set_up(book(wings, 3, 4));
    EXPECT_FALSE(any_has(setup.notes, "weld:")) << wings;
    EXPECT_EQ(setup.model.mesh.stitch.size(), 5U * static_cast<std::size_t>((wings + 1) / 2 - 1)) << wings;
    EXPECT_EQ(pieces_of(setup.model).size(), 1U) << wings;
  }
}

/// Both sides of every triangle, as in files for games.
TEST_F(Sheets, TwoSidedMeshesAreReadAsOneSheet) {
  SurfaceMesh mesh = book(2, 3, 4);
  const std::size_t count = mesh.triangles.size();
  for (std::size_t t = 0; t < count; ++t)
    mesh.triangles.push_back({mesh.triangles[t][0], mesh.triangles[t][2], mesh.triangles[t][1]});
  const drench::Setup setup = set_up(mesh);
  EXPECT_EQ(setup.model.mesh.triangles(), static_cast<Index>(count));
  EXPECT_TRUE(any_has(setup.warnings, "triangles of the mesh that repeat an earlier one are omitted: 48"));
  EXPECT_FALSE(setup.model.has_stitches());
}

/// The file's points keep their numbers in pins and seams; copies are no points of the file.
TEST_F(Sheets, CopiesAreNoPointsOfTheFile) {
  const SurfaceMesh mesh = book(3, 3, 4);
  const Index last = static_cast<Index>(mesh.points.size()) - 1;
  EXPECT_NO_THROW(set_up(mesh, "    pin: [{nodes: [" + std::to_string(last) + "]}]\n"));
  EXPECT_NE(refusal_of([&] {
              set_up(mesh, "    pin: [{nodes: [" + std::to_string(last + 1) + "]}]\n");
            }).find("allowed: 0 to " + std::to_string(last)),
            std::string::npos);
}

}  // namespace
}  // namespace drench::testing
