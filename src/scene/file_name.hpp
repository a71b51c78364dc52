#pragma once
// Files that a scene names.

#include <string>

#include "scene/yaml_tree.hpp"

namespace drench {

struct FoundFile {
  std::string path;     // absolute
  std::string problem;  // why it cannot be taken, else ""
};

/// A file that exists; a relative name starts at `folder`. `mesh`: one that can be read as a mesh.
FoundFile find_file(const yaml::Value& name, const std::string& folder, bool mesh);

}  // namespace drench
