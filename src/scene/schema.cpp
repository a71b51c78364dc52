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

constexpr const char* preface = R"(# The scene format
This file is what the loader itself knows: `drench schema > scenes/README.md` writes it, and a test compares the two.

A scene is one YAML document in UTF-8, a map of keys and values, in SI units. Unknown keys, keys given twice, values of the wrong type, not a
number or out of their range, empty lists and missing files are refused with one line, `file:line:column: key: what is wrong; allowed: …`, and exit code 2.
Ranges are written as in mathematics: `[0, 1]` is from 0 to 1, both of them allowed. Infinity is `.inf`. A scene has at most {} MB, {} levels of lists and maps,
{} values and {} keys in a map; anchors and aliases may be used, tags may not.

A value `or keys` may move with time: `[[time, value], …]`, straight between the keys, or `{{keys: [[time, value], …], interpolation: smooth}}`. Times are in
`[0, 1e6]` s and rise. `interpolation` is `linear`, `smooth` (a monotone cubic) or `step` (each value holds until the next). The first value holds before its time.

`--set key.path=value` replaces a value from the command line; `N` is the entry's number in its list, from 0: `--set cloth.0.stretch=300`.
`scene.yaml` in the folder of any run has every key with the value that was used.
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
  std::string tables;
  for (const std::string& map : maps) {
    tables += map.empty() ? "\n## The scene\n" : fmt::format("\n## `{}`\n", map);
    const SchemaKey* of_map = schema.find(map.ends_with(".N") ? map.substr(0, map.size() - 2) : map);
    if (of_map) tables += sentence(of_map->meaning) + "\n\n";
    tables += "| key | type | allowed | unit | default | meaning |\n|---|---|---|---|---|---|\n";
    for (const SchemaKey& key : schema.keys) {
      if (key.parent() != map) continue;
      tables += fmt::format("| `{}` | {} | {} | {} | {} | {} |\n", key.name(), key.type, key.allowed, unit_cell(key),
                            standard_cell(schema, key), key.meaning);
    }
  }
  return tables;
}

std::string scene_reference() {
  return fmt::format(preface, yaml::max_bytes >> 20, yaml::max_depth, yaml::max_values, yaml::max_map_keys) +
         tables_of(scene_schema());
}

}  // namespace drench
