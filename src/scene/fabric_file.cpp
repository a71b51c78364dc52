#include "scene/fabric_file.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <filesystem>
#include <string_view>

#include "scene/file_name.hpp"
#include "scene/load.hpp"
#include "scene/nearest_word.hpp"
#include "scene/scene_error.hpp"

namespace drench {
namespace {

using yaml::Value;

constexpr std::array<std::string_view, 12> fabric_keys{"areal_density", "thickness", "compression",  "stretch",
                                                       "membrane",      "bend",      "bending",      "friction",
                                                       "friction_wet",  "adhesion",  "strain_limit", "porous"};
constexpr int most_nested = 8;  // files that name files

bool is_of_fabric(const std::string& key) {
  return std::find(fabric_keys.begin(), fabric_keys.end(), key) != fabric_keys.end();
}

[[noreturn]] void refuse(const yaml::Place& place, const std::string& key, const std::string& message) {
  throw SceneError(place.text() + ": " + key, message);
}

/// The numbers and words below a map, with their dotted keys.
void collect(const Value& map, const std::string& before, const std::string& file, std::vector<FabricValue>& values) {
  for (const yaml::Entry& e : map.entries) {
    const std::string key = before + e.key;
    if (e.value.kind == Value::Kind::map) {
      collect(e.value, key + ".", file, values);
      continue;
    }
    if (e.value.kind != Value::Kind::scalar)
      refuse(e.value.place, key, fmt::format("is {}; allowed: a number or a word", e.value.shown()));
    values.push_back({key, e.value.text, "", "file", "", "", file, e.value.place});
  }
}

/// The map of a cloth's keys: of the first cloth if the file is a scene, else the whole file.
const Value& keys_of(const Value& root, const std::string& path) {
  if (root.kind != Value::Kind::map)
    throw SceneError(path + ":1:1", "fabric: is not a map; allowed: keys of a cloth, or a scene with a cloth");
  if (!root.find("drench")) {
    for (const yaml::Entry& e : root.entries)
      if (e.key != "fabric" && e.key != "about" && !is_of_fabric(e.key))
        refuse(e.place, e.key,
               fmt::format("is no key of a fabric; allowed: fabric, about, {}", fmt::join(fabric_keys, ", ")));
    return root;
  }
  const Value* cloths = root.find("cloth");
  if (!cloths || cloths->kind != Value::Kind::list || cloths->items.empty() ||
      cloths->items.front().kind != Value::Kind::map)
    throw SceneError(path + ":1:1", "cloth: is missing; allowed: a scene whose first cloth is of the fabric");
  return cloths->items.front();
}

Fabric read(const Value& name, const std::string& key, const std::string& folder, int nested) {
  const FoundFile found = find_file(name, folder, FileKind::any);
  if (!found.problem.empty()) refuse(name.place, key, found.problem + "; allowed: a fabric's name or file");
  if (nested == most_nested)
    refuse(name.place, key,
           fmt::format("is more than {} files deep, or names itself; allowed: a fabric's name or file", most_nested));
  const Value root = yaml::parse(read_document(found.path), found.path);
  const Value& keys = keys_of(root, found.path);
  Fabric fabric{name.text, "", {}};
  for (const yaml::Entry& e : keys.entries) {
    if (!is_of_fabric(e.key)) continue;
    if (e.key == "porous" && e.value.kind != Value::Kind::map)
      refuse(e.value.place, e.key, fmt::format("is {}; allowed: a map of keys", e.value.shown()));
    Value one;
    one.entries.push_back(e);
    collect(one, "", name.text, fabric.values);
  }
  const Value* base = keys.find("fabric");
  if (base && (base->kind != Value::Kind::scalar || base->text.empty()))
    refuse(base->place, "fabric", fmt::format("is {}; allowed: a fabric's name or file", base->shown()));
  if (!base && fabric.values.empty())
    throw SceneError(found.path + ":1:1",
                     fmt::format("fabric: gives no values; allowed: fabric, {}", fmt::join(fabric_keys, ", ")));
  if (!base || base->text == "none") return fabric;
  Fabric below;
  if (is_fabric_file(base->text)) {
    below = read(*base, "fabric", std::filesystem::path(found.path).parent_path().string(), nested + 1);
  } else if (const Fabric* known = fabric_named(base->text)) {
    below = *known;
  } else {
    const std::string near = nearest_word(base->text, fabric_names());
    refuse(base->place, "fabric",
           fmt::format("there is no fabric '{}';{} allowed: a fabric's name or file", base->text,
                       near.empty() ? "" : fmt::format(" did you mean '{}'?", near)));
  }
  for (FabricValue& v : below.values) {
    const bool own =
        std::any_of(fabric.values.begin(), fabric.values.end(), [&](const auto& o) { return o.key == v.key; });
    if (own || is_replaced(keys, v.key)) continue;
    v.how = v.how == "file" ? v.how : fmt::format("{}, {}", below.name, v.how);
    fabric.values.push_back(std::move(v));
  }
  return fabric;
}

}  // namespace

bool is_fabric_file(const std::string& name) { return name.ends_with(".yaml") || name.ends_with(".yml"); }

Fabric read_fabric_file(const Value& name, const std::string& key, const std::string& folder) {
  return read(name, key, folder, 0);
}

}  // namespace drench
