#pragma once
// A triangle mesh as it comes from a file or a grid, its edges, and the checks that it must pass.

#include <array>
#include <map>
#include <string>
#include <vector>

#include "base/types.hpp"

namespace drench {

/// u, v of the corners of triangles.
using TextureCorners = std::vector<std::array<std::array<double, 2>, 3>>;

struct SurfaceMesh {
  std::vector<Vec3> points;  // m
  std::vector<std::array<Index, 3>> triangles;
  TextureCorners texture{};                            // of each triangle; empty unless asked for and complete
  std::size_t untextured = 0;                          // corners of the file without a texture that others have
  std::map<std::string, std::vector<Index>> groups{};  // triangles of each name in the file; empty unless asked for
  std::string left_out{};  // one line about parts of faces that are no triangles; empty where there are none
};

/// An edge a < b with the first two triangles on it and the node opposite to it in each; −1 where there is none.
struct MeshEdge {
  Index a = 0, b = 0;
  std::array<Index, 2> triangle{-1, -1};
  std::array<Index, 2> opposite{-1, -1};
  int triangles = 0;  // how many triangles have this edge
};

/// Every edge once, ordered by (a, b).
std::vector<MeshEdge> mesh_edges(const std::vector<std::array<Index, 3>>& triangles);

/// m²
double triangle_area(const Vec3& a, const Vec3& b, const Vec3& c);
/// m, over the longest side; 0 for three points in one place
double triangle_height(const Vec3& a, const Vec3& b, const Vec3& c);

/// A cloth's mesh is refused when a triangle's area is below this fraction of its longest edge squared: cloth needs
/// finite cotangents.
inline constexpr double cloth_min_area_ratio = 1e-6;

/// Throws SetupError, beginning with `name`, for a mesh that is empty, has points that are not finite, triangles
/// without area, the same triangle twice, or an edge with more than two triangles.
void check_mesh(const SurfaceMesh& mesh, const std::string& name, double min_area_ratio);

/// Throws SetupError, beginning with `name`, for a point that is not finite or farther than 100 km from the origin.
void check_points(const std::vector<Vec3>& points, const std::string& name);

/// True when every edge has exactly two triangles, so that the mesh has an inside.
bool is_closed(const SurfaceMesh& mesh);

}  // namespace drench
