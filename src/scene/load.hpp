#pragma once
// YAML → Scene and back. Every value is checked; every default is the struct's own (scene/scene.hpp).

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "scene/scene.hpp"
#include "scene/scene_error.hpp"

namespace drench {

/// Reads and validates a scene file. Mesh files are looked up beside it and come out as absolute paths.
/// @param path the scene file
/// @param overrides each is `key.path=value`, the value in YAML and an entry of a list by its index, as in
///   `cloth.0.stretch=300`; maps that are missing on the way are made
/// @throws SceneError
Scene load_scene(const std::string& path, const std::vector<std::string>& overrides = {});

/// A file's text, one byte over the largest size of a document at most. Throws SceneError: it cannot be read.
std::string read_document(const std::string& path);

/// The same from text. Errors name it `path_for_messages`, and mesh files are looked up beside that path.
Scene parse_scene(const std::string& yaml_text, const std::string& path_for_messages,
                  const std::vector<std::string>& overrides = {});

/// The key and what is wrong with it, if a scene would have more than 10⁹ steps, frames or checkpoints. parse_scene()
/// refuses such a scene; a caller that sets another end asks again.
std::optional<std::pair<std::string, std::string>> too_often(const Scene& scene);

/// Where a key of a scene file stands, as errors begin: `file:line:column: key`. If the key is not there, it is the
/// place of the last thing on the way to it that is.
/// @param path the scene file
/// @param overrides as in load_scene()
/// @param key dotted, as in `cloth.0.stretch`; "" for the scene as a whole
std::string locate(const std::string& path, const std::vector<std::string>& overrides, const std::string& key);
/// The same in a scene's text, as parse_scene() takes it.
std::string locate_in(const std::string& yaml_text, const std::string& path_for_messages,
                      const std::vector<std::string>& overrides, const std::string& key);

/// The scene with every default written out, in the scene file's own syntax; parse_scene() gives an equal Scene back.
std::string to_yaml(const Scene& scene);

/// The same, with the basis of each number of a named fabric as a comment beside it: `assumed: of sock_nylon`.
std::string resolved_yaml(const Scene& scene);

}  // namespace drench
