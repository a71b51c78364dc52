#pragma once
// Texture coordinates of cloths and bodies for an export: the frames of a run do not hold them, the mesh files do.

#include <filesystem>
#include <string>
#include <vector>

namespace drench {

/// What write_usd.py takes of cloths and bodies that have texture coordinates:
/// `--texture=CLOTH:DESCRIPTOR` and `--body-texture=BODY:DESCRIPTOR` of an open file without a name, which holds u and
/// v of each triangle's corners as floats. Mesh files that cannot be read give a warning, a line each.
std::vector<std::string> texture_arguments(const std::filesystem::path& run_folder, std::vector<std::string>& warnings);

}  // namespace drench
