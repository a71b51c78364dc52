#pragma once
// Meshes from files, with their polygons divided into triangles.

#include <cstdint>
#include <memory>
#include <set>
#include <string>
#include <vector>

#include "setup/surface_mesh.hpp"

namespace drench {

/// Reads .obj, .ply or .stl. A polygon of n corners becomes n − 2 triangles (setup/triangulation.hpp). Those without
/// area, or that name a point twice, are left out, and SurfaceMesh::left_out has their number and the first place.
/// Points without a triangle are dropped; the others keep their order. Which triangles share a point is what the file
/// says, whatever its texture coordinates and normals are: points at the same place stay apart. An .stl file has no
/// points to share, so exact copies become one there; where more than two facets would then meet in an edge, those stay
/// together that enclose solid between them. A relative `file` is looked for beside `scene_path`, then in the working
/// folder. SetupError: no such file, unknown ending, unreadable or empty.
SurfaceMesh read_mesh(const std::string& file, const std::string& scene_path);

/// What else is read of a file that has it: texture coordinates, the groups of an .obj file, and attributes of a .ply
/// file's points. SetupError if a coordinate is not finite.
struct MeshExtras {
  bool texture = false, groups = false;
  std::set<std::string> attributes{};
};
/// The name in SurfaceMesh::groups of the triangles whose corners' mean of an attribute is `level` of paint_levels,
/// rounded.
std::string painted_group(const std::string& attribute, int level);
inline constexpr int paint_levels = 16;
SurfaceMesh read_mesh(const std::string& file, const std::string& scene_path, MeshExtras extras);

/// Reads files that have the same polygons one after the other. They are divided into triangles as in the first file,
/// and points that are one there are one in all.
class MeshSequenceReader {
 public:
  MeshSequenceReader(const std::string& file, const std::string& scene_path);
  ~MeshSequenceReader();
  const SurfaceMesh& first() const { return mesh_; }
  /// As read_mesh where a file has other polygons.
  SurfaceMesh read(const std::string& file) const;

 private:
  struct First;
  std::string path_;
  SurfaceMesh mesh_;
  std::unique_ptr<First> first_;
};

/// 1 for each point inside the mesh, which is closed and turned outwards (setup/solid_mesh.hpp).
std::vector<std::uint8_t> points_inside(const SurfaceMesh& mesh, const std::vector<Vec3>& points);

}  // namespace drench
