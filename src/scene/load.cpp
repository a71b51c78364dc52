#include "scene/load.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <map>
#include <sstream>
#include <tuple>

#include "scene/describe.hpp"
#include "scene/fabrics.hpp"
#include "scene/section_modes.hpp"

namespace drench {

namespace {

std::string folder_of(const std::string& path) { return std::filesystem::path(path).parent_path().string(); }

/// What stands at a dotted path, such as cloth.0.thickness; null if it is not a scalar.
const yaml::Value* value_at(const yaml::Value& root, const std::string& dotted) {
  const yaml::Value* value = &root;
  for (std::size_t from = 0; value && from <= dotted.size();) {
    const std::size_t to = std::min(dotted.find('.', from), dotted.size());
    const std::string part = dotted.substr(from, to - from);
    if (value->kind == yaml::Value::Kind::list) {
      const std::size_t number = std::stoul(part);
      value = number < value->items.size() ? &value->items[number] : nullptr;
    } else {
      value = value->find(part);
    }
    from = to + 1;
  }
  return value && value->kind == yaml::Value::Kind::scalar ? value : nullptr;
}

}  // namespace

std::string read_document(const std::string& path) {
  std::error_code error;
  if (std::filesystem::is_directory(path, error)) throw SceneError(path, "is a folder; allowed: a scene file");
  constexpr std::array meshes{".obj", ".ply", ".stl",  ".usd", ".usda", ".usdc",
                              ".fbx", ".glb", ".gltf", ".abc", ".blend"};
  if (const std::string ending = std::filesystem::path(path).extension().string();
      std::find(meshes.begin(), meshes.end(), ending) != meshes.end() && std::filesystem::exists(path, error))
    throw SceneError(path, "is a mesh, not a scene; to make a scene of it: drench new MESH -o scene.yaml");
  errno = 0;
  std::ifstream stream(path, std::ios::binary);
  if (!stream) throw SceneError(path, fmt::format("cannot be read: {}", std::strerror(errno)));
  std::string text;
  std::string part(std::size_t{1} << 16, '\0');
  while (text.size() <= yaml::max_bytes) {
    stream.read(part.data(), static_cast<std::streamsize>(part.size()));
    text.append(part, 0, static_cast<std::size_t>(stream.gcount()));
    if (!stream) break;
  }
  if (stream.bad()) throw SceneError(path, "cannot be read to its end");
  return text;
}

std::optional<std::pair<std::string, std::string>> too_often(const Scene& scene) {
  constexpr double most = 1e9;
  const std::tuple<const char*, const char*, double> parts[] = {
      {"time.step", "steps", scene.time.step},
      {"output.every", "frames", scene.output.every},
      {"output.checkpoint_every", "checkpoints", scene.output.checkpoint_every}};
  for (const auto& [key, what, interval] : parts)
    if (interval > 0 && scene.time.end / interval > most)
      return std::pair(std::string(key),
                       fmt::format("an interval of {} s gives {:.3g} {} until {} s; allowed: at most {:.0e}", interval,
                                   scene.time.end / interval, what, scene.time.end, most));
  return {};
}

Scene parse_scene(const std::string& yaml_text, const std::string& path_for_messages,
                  const std::vector<std::string>& overrides) {
  yaml::Value root = yaml::parse(yaml_text, path_for_messages);
  if (root.kind == yaml::Value::Kind::null && overrides.empty()) {
    throw SceneError(path_for_messages + ":1:1", "scene: is empty; allowed: a map that begins with drench: 1");
  }
  for (const std::string& override_text : overrides) yaml::apply_override(root, override_text);
  const std::string folder = folder_of(path_for_messages);
  const std::vector<FabricUse> uses = apply_fabrics(root, folder);
  Scene scene;
  scene.path = path_for_messages;
  scene.origins = origins_of(uses);
  load_section(root, folder, [&](Section& s) { describe(s, scene); });
  return scene;
}

std::string to_yaml(const Scene& scene) {
  Scene copy = scene;  // a description takes what it can change
  return save_section([&](Section& s) { describe(s, copy); });
}

std::string resolved_yaml(const Scene& scene) {
  const std::string text = to_yaml(scene);
  if (scene.origins.values.empty()) return text;
  const yaml::Value root = yaml::parse(text, "scene");
  std::map<int, std::vector<std::string>> comments;  // by line
  for (const FabricOrigin& origin : scene.origins.values) {
    const yaml::Value* value = value_at(root, origin.key);
    if (!value || std::strtod(value->text.c_str(), nullptr) != origin.value) continue;  // a program has changed it
    std::vector<std::string>& all = comments[value->place.line];
    if (std::find(all.begin(), all.end(), origin.basis) == all.end()) all.push_back(origin.basis);
  }
  std::string with_comments;
  std::istringstream lines(text);
  int number = 0;
  for (std::string line; std::getline(lines, line); with_comments += line + "\n")
    for (const std::string& comment : comments[++number])
      line += (line.find("  # ") == line.npos ? "  # " : ", ") + comment;
  return with_comments;
}

Scene load_scene(const std::string& path, const std::vector<std::string>& overrides) {
  return parse_scene(read_document(path), path, overrides);
}

std::string locate_in(const std::string& yaml_text, const std::string& path_for_messages,
                      const std::vector<std::string>& overrides, const std::string& key) {
  yaml::Value root = yaml::parse(yaml_text, path_for_messages);
  for (const std::string& override_text : overrides) yaml::apply_override(root, override_text);
  apply_fabrics(root, folder_of(path_for_messages));
  return root.place_of(key).text() + ": " + (key.empty() ? "scene" : key);
}

std::vector<FabricUse> fabrics_used(const std::string& path, const std::vector<std::string>& overrides) {
  yaml::Value root = yaml::parse(read_document(path), path);
  for (const std::string& override_text : overrides) yaml::apply_override(root, override_text);
  return apply_fabrics(root, folder_of(path));
}

std::string locate(const std::string& path, const std::vector<std::string>& overrides, const std::string& key) {
  return locate_in(read_document(path), path, overrides, key);
}

}  // namespace drench
