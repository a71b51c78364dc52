#pragma once
// Meshes from files, with their polygons divided into triangles.

#include <cstdint>
#include <memory>
#include <set>
#include <string>
#include <vector>

#include "scene/motion.hpp"
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
/// With a point cache as `sequence`, the points are where its first sample has them.
SurfaceMesh read_mesh(const std::string& file, const std::string& scene_path, MeshExtras extras,
                      const SequenceScene& sequence = {});

class PointCache;

/// The meshes of a sequence. Those of files with the same polygons are divided into triangles as the first, and points
/// that are one there are one in all.
class MeshSequenceReader {
 public:
  /// `file`: the mesh that a point cache moves, or that stands still if there is no sequence. SetupError also for a
  /// cache of another number of points than `file` has, or of an .stl file.
  MeshSequenceReader(const SequenceScene& sequence, const std::string& file, const std::string& scene_path);
  ~MeshSequenceReader();
  std::size_t size() const { return times_.size(); }
  /// s; they rise.
  const std::vector<double>& times() const { return times_; }
  /// The name of a file without its folder, or "sample 3 of walk.pc2".
  std::string label(std::size_t k) const;
  const SurfaceMesh& first() const { return mesh_; }
  /// As read_mesh where a file has other polygons.
  SurfaceMesh read(std::size_t k) const;

 private:
  struct First;
  SurfaceMesh with_points_of(const std::vector<Vec3>& points) const;

  std::string path_;
  std::vector<std::string> files_;
  std::vector<double> times_;
  std::unique_ptr<PointCache> cache_;
  SurfaceMesh mesh_;
  std::unique_ptr<First> first_;
};

/// 1 for each point inside the mesh, which is closed and turned outwards (setup/solid_mesh.hpp).
std::vector<std::uint8_t> points_inside(const SurfaceMesh& mesh, const std::vector<Vec3>& points);

}  // namespace drench
