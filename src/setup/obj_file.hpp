#pragma once
// The polygons of a Wavefront .obj file. VTK's reader follows indices that are not there, has points in single precision, and
// finds no faces where normals are defined and not used.

#include <array>
#include <cstddef>
#include <string>
#include <vector>

#include "base/types.hpp"

namespace drench {

struct ObjFile {
  std::vector<Vec3> points;                    // m
  std::vector<std::array<double, 2>> texture;  // u, v
  std::vector<std::size_t> face_end;           // of each face: one past its last corner
  std::vector<Index> corner;                   // points of all faces
  std::vector<Index> corner_texture;           // of the same corners; −1: none
  bool cut = false;  // a corner has a texture coordinate or a normal: exporters repeat points where these differ
};

/// Reads `v`, `vt` and `f`; a face may go on after a backslash, and count from the end. SetupError, with the line, for numbers
/// that are none or not finite, and for faces of fewer than three corners or of points that are not defined so far.
ObjFile read_obj_file(const std::string& path);

}  // namespace drench
