#pragma once
// Mesh files, through VTK.

#include <cstdint>
#include <string>
#include <vector>

#include "setup/surface_mesh.hpp"

namespace drench {

/// Reads .obj, .ply or .stl. Polygons are cut into triangles, exact copies of a point become one, points without a triangle are
/// dropped; the others keep their order. A relative `file` is looked for beside `scene_path`, then in the working folder.
/// SetupError: no such file, unknown ending, unreadable or empty.
SurfaceMesh read_mesh(const std::string& file, const std::string& scene_path);

/// 1 for each point inside the closed mesh, whichever way its triangles are turned.
std::vector<std::uint8_t> points_inside(const SurfaceMesh& mesh, const std::vector<Vec3>& points);

}  // namespace drench
