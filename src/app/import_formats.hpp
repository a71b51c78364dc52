#pragma once
// Files of other tools, which `drench import` reads.

#include <optional>
#include <string>

namespace drench {

/// Is it a file that is imported, rather than read as a mesh?
bool is_imported(const std::string& file);

/// ".usd, .usda, …", for messages.
std::string imported_endings();

/// The PLY files of an imported mesh.
struct ImportedMesh {
  std::string first;          // file
  std::string sequence = "";  // pattern of all files of a mesh that moves, else ""
  double per_second = 24;     // files of a sequence, 1/s
};

/// Imports its mesh `prim`, or else the only one, beside itself. Throws ExportError.
ImportedMesh imported_mesh(const std::string& file, const std::optional<std::string>& prim);

}  // namespace drench
