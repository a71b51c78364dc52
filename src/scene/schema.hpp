#pragma once
// What the loader knows of the scene format, as its readers note it (scene/reader.hpp), and the reference made of it.

#include <string>
#include <vector>

namespace drench {

struct SchemaKey {
  enum class Need { optional, one_of, required };  // one_of: exactly one of the keys of its map that are so
  std::string path;                                // entries of lists as N: cloth.N.pin.N.nodes
  std::string type;                                // number, whole number, 3 numbers, word, map, list of maps, …
  std::string allowed;                             // a range, or words
  std::string unit;                                // "" without
  std::string standard;                            // the default in YAML, "" without
  Need need = Need::optional;

  std::string parent() const;  ///< the path of its map, "" for the scene itself
  std::string name() const;    ///< the key in its map
};

/// Every key in the order in which the loader reads them; a map stands before its own keys.
struct Schema {
  std::vector<SchemaKey> keys;
};

Schema scene_schema();

/// What the key at `path` means, in a line (scene/meanings.hpp); "" if nobody wrote it down.
std::string meaning_of(const std::string& path);

/// The scene format in Markdown: every key with type, range, unit, default and meaning. It is scenes/README.md.
std::string scene_reference();

}  // namespace drench
