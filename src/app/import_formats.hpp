#pragma once
// Files of other tools, which `drench import` reads.

#include <optional>
#include <string>

namespace drench {

/// Is it a file that is imported, rather than read as a mesh?
bool is_imported(const std::string& file);

/// ".usd, .usda, …", for messages.
std::string imported_endings();

/// Imports its mesh `prim`, or else the only one, beside itself, and returns the first PLY file. Throws ExportError.
std::string imported_mesh(const std::string& file, const std::optional<std::string>& prim);

}  // namespace drench
