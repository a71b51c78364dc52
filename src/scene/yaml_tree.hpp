#pragma once
// A YAML document as a tree in which every value knows where it was written.

#include <cstddef>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace drench::yaml {

/// Where something was written: a file, or a `--set` (then line is 0).
struct Place {
  std::shared_ptr<const std::string> source;
  int line = 0, column = 0;  // from 1
  std::string text() const;  ///< `file:line:column`, or just the source when line is 0
};

struct Entry;

struct Value {
  enum class Kind { null, scalar, list, map } kind = Kind::null;
  bool quoted = false;  // a scalar in quotes is text, whatever it looks like
  std::string text;
  Place place;
  std::vector<Value> items;    // of a list
  std::vector<Entry> entries;  // of a map, in the order of the file, without duplicates

  const Value* find(const std::string& key) const;  ///< a map's value, or null
  /// The place of a dotted path, or of the last thing on the way to it that exists.
  const Place& place_of(const std::string& dotted) const;
  std::string shown() const;  ///< for messages: short, on one line
};

struct Entry {
  std::string key;
  Place place;  // of the key
  Value value;
};

/// The shortest text that reads back as the same double.
std::string text(double x);

/// The same for a list of them.
std::string text(std::span<const double> values);

/// Its control characters as \xNN, and a backslash before each character of `also`.
std::string escaped(const std::string& text, std::string_view also = {});

/// The first 40 bytes of it or so, for messages.
std::string shortened(const std::string& text);

inline constexpr std::size_t max_bytes = std::size_t{16} << 20;
inline constexpr std::size_t max_depth = 32;        // of nested lists and maps
inline constexpr std::size_t max_values = 300'000;  // with aliases written out
inline constexpr std::size_t max_map_keys = 1'000;  // in one map

/// Parses one YAML document. Throws SceneError on bad syntax, duplicate keys, tabs that indent, control characters,
/// tags, several documents, and above the limits.
Value parse(const std::string& text, const std::string& source);

/// Applies `key.path=value` to the document; see load.hpp. Throws SceneError.
void apply_override(Value& root, const std::string& override_text);

}  // namespace drench::yaml
