#pragma once
// Valid scenes at the limits of their keys, at random.

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include "scene/schema.hpp"
#include "scene/yaml_tree.hpp"
#include "scene_mutations.hpp"

namespace drench::testing {

/// Small scenes in which some keys have values at the ends of their ranges; the same ones for the same seed. Keys that
/// are not in a scene are added. The loader refuses some of them, since keys depend on each other.
class ValidScenes {
 public:
  explicit ValidScenes(std::uint64_t seed) : random_(seed), schema_(scene_schema()) {}

  /// `scene` with one to three other values.
  std::string next(const std::string& scene) {
    yaml::Value root = yaml::parse(scene, "valid.yaml");
    for (std::size_t n = 1 + below(3); n > 0; --n) {
      std::vector<Place> places;
      gather_places(root, "", places);
      change(places[below(places.size())]);
    }
    std::string text;
    write(root, text);
    return text;
  }

 private:
  struct Place {
    yaml::Value* map;
    const SchemaKey* key;
  };

  std::size_t below(std::size_t n) { return static_cast<std::size_t>(random_() % n); }
  std::string one_of(const std::vector<std::string>& values) { return values[below(values.size())]; }

  void gather_places(yaml::Value& value, const std::string& path, std::vector<Place>& places) const {
    if (value.kind == yaml::Value::Kind::map)
      for (const SchemaKey& key : schema_.keys)
        if (key.parent() == path && takes_value(key)) places.push_back({&value, &key});
    for (yaml::Entry& entry : value.entries)
      gather_places(entry.value, path.empty() ? entry.key : path + "." + entry.key, places);
    for (yaml::Value& item : value.items) gather_places(item, path + ".N", places);
  }
  static bool takes_value(const SchemaKey& key) {
    return key.path != "drench" &&
           (key.type.find("number") != std::string::npos || key.type == "word" || key.type == "switch");
  }

  void change(const Place& place) {
    yaml::Value* value = nullptr;
    for (yaml::Entry& entry : place.map->entries)
      if (entry.key == place.key->name()) value = &entry.value;
    if (!value) {
      place.map->entries.push_back({place.key->name(), {}, {}});
      value = &place.map->entries.back().value;
    }
    const std::string before = value->kind == yaml::Value::Kind::scalar ? value->text : std::string();
    *value = {};
    value->kind = yaml::Value::Kind::scalar;  // what is written stands in flow style, whatever it is
    value->text = text_for(*place.key, before);
  }

  std::string text_for(const SchemaKey& key, const std::string& before) {
    const std::string& type = key.type;
    if (type.find("number") == std::string::npos)
      return type == "word" ? one_of(words_of(key.allowed)) : one_of({"true", "false"});
    if (type == "word or number" && below(2) == 0)
      return one_of(words_of(key.allowed.substr(0, key.allowed.find_first_of("[("))));
    const bool whole = type.find("whole") != std::string::npos, list = type.starts_with("list");
    const std::size_t count = type.starts_with("2") ? 2 : type.starts_with("3") ? 3 : list ? 1 + below(4) : 1;
    const auto value = [&] {
      std::string text;
      for (std::size_t k = 0; k < count; ++k) text += (k > 0 ? ", " : "") + number(key.allowed, before, whole);
      return count > 1 || list ? "[" + text + "]" : text;
    };
    return type.ends_with("or keyframes") && below(3) > 0 ? keys_of(value, count) : value();
  }

  static std::vector<std::string> words_of(const std::string& allowed) {
    std::vector<std::string> words(1);
    for (const char c : allowed) {
      if (c == ',')
        words.emplace_back();
      else if (c != ' ' && c != '`')
        words.back() += c;
    }
    return words;
  }

  /// At an end of the range, just inside of it, or beside what stands there.
  std::string number(const std::string& allowed, const std::string& before, bool whole) {
    const std::size_t open = allowed.find_first_of("[("), comma = allowed.find(", ", open);
    if (open == std::string::npos || comma == std::string::npos) return "1";
    const double low = std::stod(allowed.substr(open + 1)), high = std::stod(allowed.substr(comma + 2));
    std::vector<double> values{low, high, 0, 1, 1e-9};
    if (std::isfinite(high - low)) values.push_back(low + 1e-9 * (high - low));
    if (const char c = before.empty() ? 'x' : before.front(); (c >= '0' && c <= '9') || c == '-')
      for (const double factor : {0.1, 0.5, 2.0, 10.0, -1.0}) values.push_back(factor * std::atof(before.c_str()));
    const double value = values[below(values.size())];
    return whole ? std::to_string(static_cast<long>(std::min(std::max(value, -2e9), 2e9))) : yaml::text(value);
  }

  /// Zero, one, equal or close keys, in each interpolation.
  template <class Value>
  std::string keys_of(const Value& value, std::size_t count) {
    const std::string zero = count == 3 ? "[0, 0, 0]" : "0", first = below(2) == 0 ? zero : value();
    const std::string other = below(2) == 0 ? first : value();
    const std::string second = one_of({"1e-12", "0.004", "1e6"}), keys = "[0, " + first + "]";
    const std::string list = below(3) == 0 ? keys : keys + ", [" + second + ", " + other + "]";
    return "{keys: [" + list + "], interpolation: " + one_of({"linear", "smooth", "step"}) + "}";
  }

  std::mt19937_64 random_;
  Schema schema_;
};

}  // namespace drench::testing
