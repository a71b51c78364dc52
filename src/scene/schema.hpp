#pragma once
// The scene format as its descriptions say it (scene/describe.hpp), and the reference made of it.

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
  std::string meaning;                             // a line of Markdown
  Need need = Need::optional;

  std::string parent() const;  ///< the path of its map, "" for the scene itself
  std::string name() const;    ///< the key in its map
};

/// Every key in the order of a resolved scene; a map stands before its own keys.
struct Schema {
  std::vector<SchemaKey> keys;
  std::vector<std::string> elsewhere;  ///< names that a map refuses by Section::not_here; paths are left out

  const SchemaKey* find(const std::string& path) const;  ///< null if there is none
};

Schema scene_schema();

/// Tables of all keys in Markdown, one a map, each with type, range, unit, default and meaning.
std::string tables_of(const Schema& schema);

/// The scene format in Markdown. It is scenes/README.md.
std::string scene_reference();

}  // namespace drench
