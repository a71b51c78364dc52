#pragma once
// YAML → Scene and back. Every value is checked; every default is the struct's own (scene/scene.hpp).

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "scene/scene.hpp"
#include "scene/scene_error.hpp"

namespace drench {

/// Reads and validates the scene file `path`. Each of `overrides` is `key.path=value`: list entries by their index
/// (`cloth.0.stretch=300`), the value in YAML; maps that are missing on the way are made.
/// Mesh files are looked up beside the scene file and come out as absolute paths. Throws SceneError.
Scene load_scene(const std::string& path, const std::vector<std::string>& overrides = {});

/// The same from text; `path_for_messages` names it in errors, and mesh files are looked up beside that path.
Scene parse_scene(const std::string& yaml_text, const std::string& path_for_messages,
                  const std::vector<std::string>& overrides = {});

/// The key and what is wrong with it, if a scene would have more than 10⁹ steps, frames or checkpoints. parse_scene refuses
/// such a scene; whoever sets another end asks again.
std::optional<std::pair<std::string, std::string>> too_often(const Scene& scene);

/// Where `key` (dotted, "" for the scene as a whole) of a scene file stands, as errors begin: `file:line:column: key`. If it
/// is not there, the place of the last thing on the way to it that is.
std::string locate(const std::string& path, const std::vector<std::string>& overrides, const std::string& key);
/// The same in a scene's text.
std::string locate_in(const std::string& yaml_text, const std::string& path_for_messages,
                      const std::vector<std::string>& overrides, const std::string& key);

/// The scene with every default written out, in the scene file's own syntax; parse_scene gives an equal Scene back.
std::string to_yaml(const Scene& scene);

}  // namespace drench
