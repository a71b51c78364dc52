#pragma once
// Files that a scene names.

#include <string>

#include "scene/yaml_tree.hpp"

namespace drench {

struct FoundFile {
  std::string path;     // absolute
  std::string problem;  // why it cannot be taken, else ""
};

enum class FileKind { any, mesh, mesh_or_point_cache };

/// A file that exists, of a kind by its ending; a relative name starts at `folder`.
FoundFile find_file(const yaml::Value& name, const std::string& folder, FileKind kind);

}  // namespace drench
