#pragma once
// Fabrics in files of their own: the key `fabric` of a cloth may name one, such as `drench fit` writes it.

#include <string>

#include "scene/fabrics.hpp"

namespace drench {

/// Is this the name of a file and not of a fabric? Files end in .yaml or .yml.
bool is_fabric_file(const std::string& name);

/// What the file gives: the fabric's keys of the first cloth if it is a scene, else of the whole file, and below them
/// those of the fabric that the file itself names. `name` and `key`: what the scene has, for messages; a relative name
/// starts at `folder`. Throws SceneError.
Fabric read_fabric_file(const yaml::Value& name, const std::string& key, const std::string& folder);

}  // namespace drench
