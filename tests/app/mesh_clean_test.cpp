// Slivers of a cloth's mesh file are removed: needles by collapsing their short edge, caps by flipping their long one.

#include "setup/mesh_clean.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "scene/scene.hpp"

namespace drench {
namespace {

constexpr Index nodes = 6;  // each way

Index node(Index i, Index j) { return j * nodes + i; }

/// A square of 5 × 5 cells of 1 cm, each of two triangles.
SurfaceMesh square() {
  SurfaceMesh mesh;
  for (Index j = 0; j < nodes; ++j)
    for (Index i = 0; i < nodes; ++i) mesh.points.push_back({0.01 * i, 0, 0.01 * j});
  for (Index j = 0; j + 1 < nodes; ++j)
    for (Index i = 0; i + 1 < nodes; ++i) {
      mesh.triangles.push_back({node(i, j), node(i, j + 1), node(i + 1, j)});
      mesh.triangles.push_back({node(i + 1, j), node(i, j + 1), node(i + 1, j + 1)});
    }
  return mesh;
}

double lowest(const SurfaceMesh& mesh) {
  double height = 1;
  for (const auto& t : mesh.triangles) {
    double longest = 0;
    for (std::size_t k = 0; k < 3; ++k) {
      const Vec3 &a = mesh.points[std::size_t(t[k])], &b = mesh.points[std::size_t(t[(k + 1) % 3])];
      longest = std::max(longest, std::hypot(a[0] - b[0], a[1] - b[1], a[2] - b[2]));
    }
    height = std::min(height, 2 *
                                  triangle_area(mesh.points[std::size_t(t[0])], mesh.points[std::size_t(t[1])],
                                                mesh.points[std::size_t(t[2])]) /
                                  longest);
  }
  return height;
}

double area(const SurfaceMesh& mesh) {
  double sum = 0;
  for (const auto& t : mesh.triangles)
    sum +=
        triangle_area(mesh.points[std::size_t(t[0])], mesh.points[std::size_t(t[1])], mesh.points[std::size_t(t[2])]);
  return sum;
}

/// Nodes − edges + triangles; 1 for a disc.
int euler(const SurfaceMesh& mesh) {
  const auto edges = mesh_edges(mesh.triangles);
  for (const MeshEdge& e : edges) EXPECT_LE(e.triangles, 2);
  return int(mesh.points.size()) - int(edges.size()) + int(mesh.triangles.size());
}

TEST(MeshClean, LeavesAGoodMeshAsItIs) {
  SurfaceMesh mesh = square();
  const MeshCleaning done = clean_mesh(mesh, clean_automatically);
  EXPECT_FALSE(done.found());
  EXPECT_EQ(mesh.triangles, square().triangles);
  EXPECT_EQ(mesh.points, square().points);
}

TEST(MeshClean, CollapsesNeedles) {
  SurfaceMesh mesh = square();
  mesh.points[node(2, 2)][0] = mesh.points[node(3, 2)][0] - 1e-5;
  mesh.groups["all"].resize(mesh.triangles.size());
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) mesh.groups["all"][t] = Index(t);
  const MeshCleaning done = clean_mesh(mesh, clean_automatically);
  EXPECT_EQ(done.collapsed, 1) << done.text();
  EXPECT_EQ(done.left, 0);
  EXPECT_EQ(done.node[node(2, 2)], done.node[node(3, 2)]);
  EXPECT_EQ(done.node.back(), Index(mesh.points.size()) - 1);
  EXPECT_EQ(mesh.points.size(), 35u);
  EXPECT_EQ(mesh.triangles.size(), 48u);
  EXPECT_EQ(mesh.groups["all"].size(), 48u);
  EXPECT_EQ(euler(mesh), 1);
  EXPECT_GT(lowest(mesh), 0.003);
  EXPECT_NEAR(area(mesh), 25e-4, 1e-10);
}

TEST(MeshClean, KeepsTheBoundaryWhereANeedleTouchesIt) {
  SurfaceMesh mesh = square();
  mesh.points[node(1, 2)][0] = 1e-5;  // next to node (0, 2)
  const std::vector<Vec3> before = mesh.points;
  const MeshCleaning done = clean_mesh(mesh, clean_automatically);
  EXPECT_EQ(done.collapsed, 1) << done.text();
  EXPECT_EQ(mesh.points[std::size_t(done.node[node(1, 2)])][0], 0) << "m: the boundary is where it was";
  ASSERT_EQ(done.kept.size(), mesh.points.size());
  for (std::size_t n = 0; n < mesh.points.size(); ++n) EXPECT_EQ(mesh.points[n], before[std::size_t(done.kept[n])]);
  EXPECT_EQ(euler(mesh), 1);
  EXPECT_NEAR(area(mesh), 25e-4, 1e-10);
}

/// A quadrilateral whose lower triangle is a cap: its third corner lies almost on the diagonal.
SurfaceMesh cap() {
  return {.points = {{0, 0, 0}, {0.02, 0, 0}, {0.01, 0, 0.01}, {0.01, 0, -1e-5}}, .triangles = {{0, 2, 1}, {0, 1, 3}}};
}

TEST(MeshClean, FlipsTheLongEdgeOfACap) {
  SurfaceMesh mesh = cap();
  const double before = area(mesh);
  const MeshCleaning done = clean_mesh(mesh, clean_automatically);
  EXPECT_EQ(done.flipped, 1) << done.text();
  EXPECT_EQ(mesh.points.size(), 4u);
  EXPECT_GT(lowest(mesh), 0.005);
  EXPECT_NEAR(area(mesh), before, 1e-15);
  EXPECT_EQ(euler(mesh), 1);
}

TEST(MeshClean, FlipsNothingAcrossRegionsOrSeamsOfTheTexture) {
  SurfaceMesh regions = cap();
  regions.groups["hem"] = {1};
  EXPECT_EQ(clean_mesh(regions, clean_automatically).flipped, 0);
  SurfaceMesh seam = cap();
  seam.texture = {{{{0, 0}, {0.5, 0.5}, {1, 0}}}, {{{0.2, 0}, {1, 0}, {0.5, 0}}}};
  EXPECT_EQ(clean_mesh(seam, clean_automatically).left, 1);
  seam.texture = {{{{0, 0}, {0.5, 0.5}, {1, 0}}}, {{{0, 0}, {1, 0}, {0.5, -0.1}}}};
  EXPECT_EQ(clean_mesh(seam, clean_automatically).flipped, 1);
  for (std::size_t t = 0; t < 2; ++t)
    for (std::size_t k = 0; k < 3; ++k)
      EXPECT_NEAR(seam.texture[t][k][0], seam.points[std::size_t(seam.triangles[t][k])][0] / 0.02, 1e-12);
}

TEST(MeshClean, RemovesACapAtTheBoundary) {
  SurfaceMesh mesh = cap();
  mesh.points = {{0, 0, 0}, {0.02, 0, 0}, {0.01, 0, 1e-5}, {0.01, 0, 0.01}};
  mesh.triangles = {{0, 2, 1}, {0, 3, 2}, {2, 3, 1}};
  const MeshCleaning done = clean_mesh(mesh, clean_automatically);
  EXPECT_EQ(done.dropped, 1) << done.text();
  EXPECT_EQ(mesh.triangles.size(), 2u);
  EXPECT_EQ(euler(mesh), 1);
}

TEST(MeshClean, NeverTurnsATriangleOver) {
  // Each second node of a row is moved next to its neighbour: needles side by side.
  SurfaceMesh mesh = square();
  for (Index i = 1; i < 5; i += 2)
    for (Index j = 1; j < 5; ++j) mesh.points[node(i, j)][0] = mesh.points[node(i + 1, j)][0] - 2e-5;
  clean_mesh(mesh, clean_automatically);
  for (const auto& t : mesh.triangles) {
    const Vec3 &a = mesh.points[std::size_t(t[0])], &b = mesh.points[std::size_t(t[1])],
               &c = mesh.points[std::size_t(t[2])];
    EXPECT_GT((b[2] - a[2]) * (c[0] - a[0]) - (b[0] - a[0]) * (c[2] - a[2]), 0);
  }
  EXPECT_EQ(euler(mesh), 1);
  EXPECT_NEAR(area(mesh), 25e-4, 1e-10);
}

}  // namespace
}  // namespace drench
