#include "scene/schema.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "scene/describe.hpp"
#include "scene/section_modes.hpp"

namespace drench {

namespace {

/// "(the number of a node)" is for error messages.
std::string unit_cell(const SchemaKey& key) { return key.unit.starts_with('(') ? "" : key.unit; }

std::string sentence(std::string text) {
  if (!text.empty() && text[0] >= 'a' && text[0] <= 'z') text[0] = static_cast<char>(text[0] - 'a' + 'A');
  return text + ".";
}

/// A default stands in the table as YAML has it; a key that must be given says so.
std::string standard_cell(const Schema& schema, const SchemaKey& key) {
  if (key.need == SchemaKey::Need::one_of) return "one of these";
  if (key.need == SchemaKey::Need::optional) return key.standard.empty() ? "" : fmt::format("`{}`", key.standard);
  const std::string map = key.parent();
  const bool in_list = map.find(".N") != map.npos;
  const SchemaKey* of_map = schema.find(map);
  const bool optional_map = of_map && of_map->need == SchemaKey::Need::optional;
  if (in_list || !optional_map || key.standard.empty()) return "required";
  return fmt::format("required; without `{}`: `{}`", map, key.standard);
}

constexpr const char* preface = R"(# Scene file reference

A scene is a YAML file in UTF-8 and SI units. This page lists every key; `drench schema` prints the same text.

Unknown keys, repeated keys, wrong types, values out of range, empty lists and missing files are rejected with exit
code 2 and one line, `file:line:column: key: what is wrong; allowed: …`. In ranges, `[0, 1]` includes both ends and
`(0, 1]` excludes 0. Infinity is `.inf`. A scene may have at most {} MB, {} levels of lists and maps, {} values, and
{} keys per map. Anchors and aliases are allowed, tags are not.

Values whose type ends with *or keyframes* may vary in time. `[[time, value], …]` interpolates linearly.
`{{keys: [[time, value], …], interpolation: smooth}}` chooses `linear`, `smooth` (a monotone cubic) or `step` (each
value holds until the next). Times are in `[0, 1e6]` s and must increase. The first value also applies before its time,
and the last one after.

`--set key.path=value` overrides a value on the command line. `N` is the position of an entry in its list, from 0:
`--set cloth.0.stretch=300`.
The file `scene.yaml` in the output folder of a run contains every key with the value that was used.
)";

}  // namespace

std::string SchemaKey::parent() const { return path.find('.') == path.npos ? "" : path.substr(0, path.rfind('.')); }

std::string SchemaKey::name() const { return path.substr(path.rfind('.') + 1); }

const SchemaKey* Schema::find(const std::string& path) const {
  const auto found = std::find_if(keys.begin(), keys.end(), [&](const SchemaKey& key) { return key.path == path; });
  return found == keys.end() ? nullptr : &*found;
}

Schema scene_schema() {
  Scene scene;
  return document_section([&](Section& s) { describe(s, scene); });
}

std::string tables_of(const Schema& schema) {
  std::vector<std::string> maps;
  for (const SchemaKey& key : schema.keys)
    if (std::find(maps.begin(), maps.end(), key.parent()) == maps.end()) maps.push_back(key.parent());
  struct Part {
    std::string heading, text;
  };
  std::vector<Part> parts;  // sections that say the same share one
  for (const std::string& map : maps) {
    std::string text;
    const SchemaKey* of_map = schema.find(map.ends_with(".N") ? map.substr(0, map.size() - 2) : map);
    if (of_map) text += sentence(of_map->meaning) + "\n\n";
    text += "| Key | Type | Allowed | Unit | Default | Description |\n|---|---|---|---|---|---|\n";
    for (const SchemaKey& key : schema.keys) {
      if (key.parent() != map) continue;
      text += fmt::format("| `{}` | {} | {} | {} | {} | {} |\n", key.name(), key.type, key.allowed, unit_cell(key),
                          standard_cell(schema, key), key.meaning);
    }
    const auto same = std::find_if(parts.begin(), parts.end(), [&](const Part& part) { return part.text == text; });
    if (same != parts.end())
      same->heading += fmt::format(", `{}`", map);
    else
      parts.push_back({map.empty() ? "The scene" : fmt::format("`{}`", map), text});
  }
  std::string tables;
  for (const Part& part : parts) tables += fmt::format("\n## {}\n{}", part.heading, part.text);
  return tables;
}

std::string scene_reference() {
  return fmt::format(preface, yaml::max_bytes >> 20, yaml::max_depth, yaml::max_values, yaml::max_map_keys) +
         tables_of(scene_schema());
}

}  // namespace drench
