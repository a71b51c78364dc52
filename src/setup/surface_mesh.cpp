#include "setup/surface_mesh.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "base/eigen_vec.hpp"
#include "setup/setup_error.hpp"

namespace drench {

std::vector<MeshEdge> mesh_edges(const std::vector<std::array<Index, 3>>& triangles) {
  struct Side {
    Index a, b, triangle, opposite;
  };
  std::vector<Side> sides;
  sides.reserve(3 * triangles.size());
  for (std::size_t t = 0; t < triangles.size(); ++t) {
    const auto& n = triangles[t];
    for (int c = 0; c < 3; ++c) {
      const Index i = n[(c + 1) % 3], j = n[(c + 2) % 3];
      sides.push_back({std::min(i, j), std::max(i, j), static_cast<Index>(t), n[c]});
    }
  }
  std::sort(sides.begin(), sides.end(), [](const Side& l, const Side& r) {
    return std::array{l.a, l.b, l.triangle} < std::array{r.a, r.b, r.triangle};
  });
  std::vector<MeshEdge> edges;
  for (const Side& s : sides) {
    if (edges.empty() || edges.back().a != s.a || edges.back().b != s.b) {
      edges.emplace_back();
      edges.back().a = s.a;
      edges.back().b = s.b;
    }
    MeshEdge& e = edges.back();
    if (e.triangles < 2) {
      e.triangle[e.triangles] = s.triangle;
      e.opposite[e.triangles] = s.opposite;
    }
    ++e.triangles;
  }
  return edges;
}

double triangle_area(const Vec3& a, const Vec3& b, const Vec3& c) {
  return 0.5 * (to_eigen(b) - to_eigen(a)).cross(to_eigen(c) - to_eigen(a)).norm();
}

double triangle_height(const Vec3& a, const Vec3& b, const Vec3& c) {
  const double longest = std::max(
      {(to_eigen(b) - to_eigen(a)).norm(), (to_eigen(c) - to_eigen(b)).norm(), (to_eigen(a) - to_eigen(c)).norm()});
  return longest > 0 ? 2 * triangle_area(a, b, c) / longest : 0;
}

void check_points(const std::vector<Vec3>& points, const std::string& name) {
  constexpr double farthest = 1e5;  // m; in single precision rounded to 8 mm
  for (std::size_t i = 0; i < points.size(); ++i) {
    const Vec3& x = points[i];
    if (!to_eigen(x).allFinite())
      throw SetupError(fmt::format("{}: point {} of the mesh is not a finite number", name, i));
    if (to_eigen(x).cwiseAbs().maxCoeff() > farthest)
      throw SetupError(
          fmt::format("{}: point {} of the mesh is at ({:.3g}, {:.3g}, {:.3g}) m; allowed: coordinates from -{} to {} "
                      "m; check the file, unit and scale",
                      name, i, x[0], x[1], x[2], farthest, farthest));
  }
}

void check_mesh(const SurfaceMesh& mesh, const std::string& name, double min_area_ratio) {
  if (mesh.triangles.empty()) throw SetupError(name + ": the mesh has no triangles");
  check_points(mesh.points, name);
  std::vector<std::array<Index, 4>> sorted;  // the nodes in rising order, and the triangle
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    const auto& n = mesh.triangles[t];
    const auto at = [&](int c) { return to_eigen(mesh.points[static_cast<std::size_t>(n[c])]); };
    const double longest =
        std::max({(at(1) - at(0)).squaredNorm(), (at(2) - at(1)).squaredNorm(), (at(0) - at(2)).squaredNorm()});
    const double area = 0.5 * (at(1) - at(0)).cross(at(2) - at(0)).norm();
    if (!(area > min_area_ratio * longest)) {
      throw SetupError(
          fmt::format("{}: triangle {} of the mesh (points {}, {}, {}) is degenerate: its area is {:.3g} m²", name, t,
                      n[0], n[1], n[2], area));
    }
    sorted.push_back({n[0], n[1], n[2], static_cast<Index>(t)});
    std::sort(sorted.back().begin(), sorted.back().begin() + 3);
  }
  std::sort(sorted.begin(), sorted.end());
  for (std::size_t i = 1; i < sorted.size(); ++i) {
    if (std::equal(sorted[i].begin(), sorted[i].begin() + 3, sorted[i - 1].begin())) {
      throw SetupError(
          fmt::format("{}: triangles {} and {} of the mesh are the same (points {}, {}, {}); remove one of them", name,
                      sorted[i - 1][3], sorted[i][3], sorted[i][0], sorted[i][1], sorted[i][2]));
    }
  }
  for (const MeshEdge& e : mesh_edges(mesh.triangles)) {
    if (e.triangles > 2) {
      throw SetupError(
          fmt::format("{}: the mesh is not a manifold: the edge between points {} and {} has {} triangles, "
                      "at most 2 are allowed",
                      name, e.a, e.b, e.triangles));
    }
  }
}

bool is_closed(const SurfaceMesh& mesh) {
  const auto edges = mesh_edges(mesh.triangles);
  return !edges.empty() && std::all_of(edges.begin(), edges.end(), [](const MeshEdge& e) { return e.triangles == 2; });
}

}  // namespace drench
