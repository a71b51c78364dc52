#pragma once
// What a mesh file must hold before VTK reads it: VTK's readers follow any index and any count.

#include <string>

namespace drench {

/// Throws SetupError: the file cannot be read, and why.
[[noreturn]] void unreadable_mesh(const std::string& path, const std::string& why);

/// Throws SetupError, with the line or the element, for a header that is none, and for fewer or other numbers than it says.
void check_ply_file(const std::string& path);

/// Throws SetupError for a text that does not begin with `solid`, and for a binary file with fewer triangles than it says.
void check_stl_file(const std::string& path);

}  // namespace drench
