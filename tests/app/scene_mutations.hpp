#pragma once
// Mistakes in scenes, at random.

#include <cstdint>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include "scene/yaml_tree.hpp"

namespace drench::testing {

/// Everything that a mutation may touch, gathered anew for each one.
struct MutationPlaces {
  std::vector<yaml::Value*> maps, lists, scalars, all;        // maps and lists that hold something
  std::vector<std::pair<yaml::Value*, std::size_t>> entries;  // a map and the number of its entry
};

inline void gather(yaml::Value& value, MutationPlaces& places) {
  places.all.push_back(&value);
  if (value.kind == yaml::Value::Kind::scalar) places.scalars.push_back(&value);
  if (!value.entries.empty()) places.maps.push_back(&value);
  if (!value.items.empty()) places.lists.push_back(&value);
  for (std::size_t e = 0; e < value.entries.size(); ++e) {
    places.entries.emplace_back(&value, e);
    gather(value.entries[e].value, places);
  }
  for (yaml::Value& item : value.items) gather(item, places);
}

/// A document in flow style, a line for every entry, so that places differ.
inline void write(const yaml::Value& value, std::string& out) {
  switch (value.kind) {
    case yaml::Value::Kind::null:
      out += "~";
      return;
    case yaml::Value::Kind::scalar: {
      if (!value.quoted) {
        out += value.text;
        return;
      }
      out += '"';
      for (const char c : value.text) out += (c == '"' || c == '\\' ? "\\" : "") + std::string(1, c);
      out += '"';
      return;
    }
    case yaml::Value::Kind::list:
      out += "[";
      for (std::size_t i = 0; i < value.items.size(); ++i) {
        if (i > 0) out += ", ";
        write(value.items[i], out);
      }
      out += "]";
      return;
    case yaml::Value::Kind::map:
      out += "{";
      for (std::size_t e = 0; e < value.entries.size(); ++e) {
        out += (e > 0 ? ",\n" : "\n") + value.entries[e].key + ": ";
        write(value.entries[e].value, out);
      }
      out += "}";
      return;
  }
}

/// Good scenes with one mistake each; the same ones for the same seed.
class Mutations {
 public:
  explicit Mutations(std::uint64_t seed) : random_(seed) {}

  static constexpr std::size_t kinds = 12;

  /// The scene with one mistake of this kind.
  std::string of(const std::string& good, std::size_t kind) {
    if (kind < 3) return damaged(good, kind);
    yaml::Value root = yaml::parse(good, "good.yaml");
    MutationPlaces at;
    gather(root, at);
    mutate(at, kind);
    std::string text;
    write(root, text);
    return text;
  }

 private:
  std::size_t below(std::size_t n) { return static_cast<std::size_t>(random_() % n); }
  template <class T>
  const T& one_of(const std::vector<T>& values) {
    return values[below(values.size())];
  }

  std::string damaged(std::string text, std::size_t kind) {
    const std::size_t at = below(text.size());
    if (kind == 0) return text.substr(0, at);  // cut short
    if (kind == 1) {                           // bytes that are no text
      for (std::size_t n = 1 + below(40); n > 0; --n) text.insert(at, 1, static_cast<char>(below(256)));
      return text;
    }
    // a mark too many, or one too few
    const std::vector<std::string> marks{"[",  "]",  "{",   "}",     ":",      ": ",   "- ", "\t", "\n",
                                         "\"", "'",  "&a ", "*a",    "!!int ", "|",    ">",  "%",  "@",
                                         "`",  "# ", ",",   "---\n", "? ",     "<<: ", "..."};
    for (std::size_t n = 1 + below(3); n > 0; --n) text.insert(below(text.size() + 1), one_of(marks));
    return text;
  }

  yaml::Value wrong_type(const yaml::Value& was) {
    yaml::Value other;
    const std::vector<std::string> words{"true", "yes", "water", "0", "[]", "{}", "~", "1 m", "\"0.5\""};
    switch (below(4)) {
      case 0:
        return other;  // nothing
      case 1:
        other.kind = yaml::Value::Kind::list;
        other.items = {was};
        return other;
      case 2:
        other.kind = yaml::Value::Kind::map;
        other.entries = {{"value", {}, was}};
        return other;
      default:
        other.kind = yaml::Value::Kind::scalar;
        other.text = one_of(words);
        return other;
    }
  }

  std::string misspelt(std::string word) {
    if (word.empty()) return "x";
    const std::size_t at = below(word.size());
    switch (below(5)) {
      case 0:
        return word.erase(at, 1).empty() ? "x" : word;
      case 1:
        return word.insert(at, 1, static_cast<char>('a' + below(26)));
      case 2:
        return word + "s";
      case 3:
        word[at] = word[at] >= 'a' && word[at] <= 'z' ? static_cast<char>(word[at] - 'a' + 'A') : 'x';
        return word;
      default:
        return one_of(std::vector<std::string>{"colour", "value", "N", "0", "cloth.0", "min", "é", "y"});
    }
  }

  void mutate(const MutationPlaces& at, std::size_t kind) {
    static const std::vector<std::string> numbers{
        "1e300", "-1e300", "1e-300", "-1",    "0",    "-0.0",       ".nan",        ".inf",
        "-.inf", "1e999",  "-1e999", "1e-9",  "1e-5", "2147483647", "-2147483648", "99999999999999999999",
        "0x10",  "1_000",  "1,5",    "1.5",   "1e5",  "10000",      "4 ms",        "nan",
        "inf",   "1e",     "--1",    "0.1.2", "1000", "5e-324",     "3.4e38",      "1e-3"};
    const auto entry = [&]() -> std::pair<yaml::Value*, std::size_t> { return one_of(at.entries); };
    switch (kind) {
      case 3: {  // a key deleted
        const auto [map, e] = entry();
        map->entries.erase(map->entries.begin() + static_cast<std::ptrdiff_t>(e));
        return;
      }
      case 4: {  // renamed
        const auto [map, e] = entry();
        map->entries[e].key = misspelt(map->entries[e].key);
        return;
      }
      case 5: {  // given twice
        const auto [map, e] = entry();
        const yaml::Entry copy = map->entries[e];
        map->entries.insert(map->entries.begin() + static_cast<std::ptrdiff_t>(below(map->entries.size() + 1)), copy);
        return;
      }
      case 6:  // another type
      {
        yaml::Value* value = one_of(at.all);
        *value = wrong_type(yaml::Value(*value));
        return;
      }
      case 7:
      case 8: {  // another number
        yaml::Value* value = one_of(at.scalars);
        value->quoted = false;
        value->text = one_of(numbers);
        return;
      }
      case 9: {  // an empty list or map
        yaml::Value* value = below(2) == 0 ? one_of(at.maps) : one_of(at.lists);
        value->entries.clear();
        value->items.clear();
        return;
      }
      case 10: {  // a list too short or too long
        yaml::Value* list = one_of(at.lists);
        if (below(2) == 0)
          list->items.pop_back();
        else
          list->items.push_back(yaml::Value(list->items[below(list->items.size())]));
        return;
      }
      default: {  // a part of the scene somewhere else
        const yaml::Value copy = *one_of(at.all);
        const auto [map, e] = entry();
        map->entries[e].value = copy;
        return;
      }
    }
  }

  std::mt19937_64 random_;
};

}  // namespace drench::testing
