#pragma once
// The names of the faces in a mesh file, for the regions of a cloth.

#include <string>
#include <vector>

namespace drench {

/// Of each face of an .obj file, in the order of the file: the names that the last `g`, `o` and `usemtl` before it give.
std::vector<std::vector<std::string>> face_names(const std::string& path);

}  // namespace drench
