#pragma once
// Mesh files by format: readers of .obj, .ply and of .stl texts, and what VTK must not be given of binary .stl.

#include <array>
#include <cstddef>
#include <cstdint>
#include <map>
#include <set>
#include <string>
#include <vector>

#include "base/types.hpp"

namespace drench {

struct PolygonFile {
  std::vector<Vec3> points;                     // in the file's unit
  std::vector<std::array<double, 2>> texture;   // u, v, 1; not all need be finite
  std::vector<std::size_t> face_end;            // of each face: one past its last corner
  std::vector<Index> corner;                    // points of all faces
  std::vector<Index> corner_texture;            // of the same corners; −1: none
  std::vector<std::vector<std::string>> names;  // of each face; empty unless asked for
  std::vector<std::int32_t> face_line;          // of each face, from 1; empty where a format has no lines
  std::vector<Vec3> velocity;                   // of points, in that unit per s; only of particles that have it
  std::vector<double> mass;                     // kg; likewise
  std::vector<std::int64_t> id;                 // likewise
  std::map<std::string, std::vector<double>> attributes;  // of points: those asked for that the file has, 0 to 1
  std::string note;                                       // a doubt whether the file is complete, else ""
  bool facets = false;  // each face has points of its own (.stl): copies of a point are one
};

/// Reads `v`, `vt` and `f` of a Wavefront file, and with `names` what the last `g`, `o` and `usemtl` before a face give
/// it. A line may go on after a backslash, indices may count from the end. SetupError, with the line: a point that is
/// not three finite numbers, a face of fewer than three corners or of points or texture coordinates that are not
/// defined so far.
PolygonFile read_obj_file(const std::string& path, bool names = false);

/// Reads the elements `vertex` and `face` of a PLY file, ascii or binary, and steps over the others. SetupError, with
/// the line or the element: a header that is none, fewer or other numbers than it says, faces of points that are not
/// there. With `particles`, what the points have as vx, vy, vz, as mass and as id is read too, and `attributes` by
/// their names. Whole numbers of these are over the largest of their type, as colours are.
PolygonFile read_ply_file(const std::string& path, bool particles = false,
                          const std::set<std::string>& attributes = {});

/// Is an .stl file a text? VTK tells it in the same way.
bool is_stl_text(const std::string& bytes);

/// Is it a binary .stl file whose header fits its `size` (bytes)? `bytes`: those that it begins with.
bool is_binary_stl(const std::string& bytes, std::size_t size);

/// Three points per facet. The coordinates have single precision, as those of a binary file. SetupError, with the line:
/// a word that does not belong there, a vertex that is not three finite numbers, or an end before `endsolid`.
PolygonFile read_stl_text(const std::string& path, const std::string& bytes);

/// SetupError for a binary .stl file with fewer triangles than its header gives; a note about one with more, else "".
std::string check_stl_file(const std::string& path, const std::string& bytes);

/// Throws SetupError if the contents are clearly of something else than the file's ending (".obj") says: a Git LFS
/// pointer, a web page, another format, or nothing at all.
void check_mesh_content(const std::string& path, const std::string& ending);

/// The bytes of a file. SetupError: it cannot be opened.
std::string bytes_of_mesh(const std::string& path);

/// Throws SetupError: the file cannot be read, and why.
[[noreturn]] void unreadable_mesh(const std::string& path, const std::string& why);

}  // namespace drench
