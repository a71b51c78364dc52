#include "scene/load.hpp"

#include <fmt/format.h>

#include <cerrno>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <tuple>

#include "scene/describe.hpp"
#include "scene/fabrics.hpp"
#include "scene/section_modes.hpp"

namespace drench {

namespace {

/// The file's text, one byte over the limit at most.
std::string read_text(const std::string& path) {
  std::error_code error;
  if (std::filesystem::is_directory(path, error)) throw SceneError(path, "is a folder; allowed: a scene file");
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

}  // namespace

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
  apply_fabrics(root);
  Scene scene;
  scene.path = path_for_messages;
  load_section(root, std::filesystem::path(path_for_messages).parent_path().string(),
               [&](Section& s) { describe(s, scene); });
  return scene;
}

std::string to_yaml(const Scene& scene) {
  Scene copy = scene;  // a description takes what it can change
  return save_section([&](Section& s) { describe(s, copy); });
}

Scene load_scene(const std::string& path, const std::vector<std::string>& overrides) {
  return parse_scene(read_text(path), path, overrides);
}

std::string locate_in(const std::string& yaml_text, const std::string& path_for_messages,
                      const std::vector<std::string>& overrides, const std::string& key) {
  yaml::Value root = yaml::parse(yaml_text, path_for_messages);
  for (const std::string& override_text : overrides) yaml::apply_override(root, override_text);
  apply_fabrics(root);
  return root.place_of(key).text() + ": " + (key.empty() ? "scene" : key);
}

std::vector<FabricUse> fabrics_used(const std::string& path, const std::vector<std::string>& overrides) {
  yaml::Value root = yaml::parse(read_text(path), path);
  for (const std::string& override_text : overrides) yaml::apply_override(root, override_text);
  return apply_fabrics(root);
}

std::string locate(const std::string& path, const std::vector<std::string>& overrides, const std::string& key) {
  return locate_in(read_text(path), path, overrides, key);
}

}  // namespace drench
