#pragma once
// Reads the sections of a scene so that their readers look like the schema: key, where it goes, range, unit.

#include <array>
#include <initializer_list>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "scene/scene_error.hpp"
#include "scene/schema.hpp"
#include "scene/yaml_tree.hpp"
#include "state/types.hpp"

namespace drench {

/// One word that a key may take. `available` false: known to the format, refused by this version.
template <class T>
struct Choice {
  const char* word;
  T value;
  bool available = true;
};

/// One map of the scene file. A key that is absent leaves the struct's own default. A bad value throws at once; done()
/// then reports unknown keys before missing ones, and missing ones before failed checks between keys.
/// Ranges are written as in mathematics: "(0, 1]"; "[0, inf]" with a closed end admits infinity. Unit "1": no unit.
/// With a Schema instead of a map it notes what it would read, and finds no key: the readers themselves are the schema. They
/// call every method whatever the file holds, so that nothing is missing there.
class Section {
 public:
  /// `path` is the map's key path, "" for the root; `folder` is where relative mesh files lie.
  Section(const yaml::Value& map, std::string path, std::string folder);
  Section(Schema& schema, std::string path);

  /// Keys that have no default. To be called before they are read.
  void required(std::initializer_list<const char*> keys) { required_.insert(keys.begin(), keys.end()); }

  void number(const char* key, double& out, const char* range, const char* unit);
  void number(const char* key, std::optional<double>& out, const char* range, const char* unit);  // has no default
  void integer(const char* key, int& out, const char* range, const char* unit);
  void numbers(const char* key, Vec3& out, const char* range, const char* unit);
  void numbers(const char* key, std::array<double, 2>& out, const char* range, const char* unit);
  void integers(const char* key, std::array<int, 2>& out, const char* range, const char* unit);
  void integers(const char* key, std::vector<Index>& out, const char* range, const char* unit);  // not empty
  void boolean(const char* key, bool& out);
  void text(const char* key, std::string& out);  // not empty, up to 100 bytes, no control characters
  /// A mesh file that exists; becomes an absolute path.
  void mesh_file(const char* key, std::string& out);
  /// Just `key: true`; returns whether it stands there.
  bool flag(const char* key);

  template <class T>
  void choice(const char* key, T& out, const std::vector<Choice<T>>& choices) {
    std::vector<std::pair<std::string, bool>> words;
    std::string standard;
    for (const auto& choice : choices) {
      words.emplace_back(choice.word, choice.available);
      if (choice.value == out) standard = choice.word;
    }
    const int index = word_index(key, words, standard);
    if (index >= 0) out = choices[static_cast<std::size_t>(index)].value;
  }

  /// A map, read by read(Section&, T&); returns whether it stands there.
  template <class T, class Read>
  bool section(const char* key, T& out, Read read) {
    if (schema_) {
      note(key, "map");
      Section sub(*schema_, path_of(key));
      read(sub, out);
      return false;
    }
    const yaml::Value* value = take(key, "a map");
    if (!value) return false;
    Section sub(*value, path_of(key), folder_);
    read(sub, out);
    sub.done();
    return true;
  }

  /// A map that becomes one more entry of a vector, read by read(Section&, T&).
  template <class T, class Read>
  void entry(const char* key, std::vector<T>& out, Read read) {
    T one;
    if (section(key, one, read)) out.push_back(std::move(one));
  }

  /// A list of maps that is not empty, each read by read(Section&, out).
  template <class T, class Read>
  void each(const char* key, T& out, Read read) {
    if (schema_) {
      note(key, "list of maps");
      Section sub(*schema_, path_of(key) + ".N");
      return read(sub, out);
    }
    const yaml::Value* value = take(key, "a list of maps");
    if (!value) return;
    check_list(key, *value);
    for (std::size_t i = 0; i < value->items.size(); ++i) {
      Section sub(value->items[i], path_of(key) + "." + std::to_string(i), folder_);
      read(sub, out);
      sub.done();
    }
  }

  /// The same into a vector, one entry per map, read by read(Section&, T&).
  template <class T, class Read>
  void list(const char* key, std::vector<T>& out, Read read) {
    each(key, out, [&](Section& item, std::vector<T>& all) { read(item, all.emplace_back()); });
  }

  /// Exactly one of these keys must stand in this map, beside any of `others`; returns which ("" with a Schema).
  /// Throws at once.
  std::string one_of(std::initializer_list<const char*> keys, std::initializer_list<const char*> others = {});

  bool has(const char* key) const { return map_.find(key) != nullptr; }
  /// A relation between keys: when not `good`, done() reports `message` at `key` (dotted, from here).
  void check(bool good, const std::string& key, const std::string& message);
  /// A feature that the format knows and this version lacks: when `asked`, done() refuses it at `key`.
  void not_available(bool asked, const std::string& key, const std::string& feature, const std::string& allowed);
  /// Throws the first complaint that waited. Called by section(), each() and list().
  void done() const;

 private:
  std::string path_of(const std::string& key) const;
  const yaml::Value* take(const char* key, const std::string& expected);
  void check_list(const char* key, const yaml::Value& value) const;
  void check_known() const;
  int word_index(const char* key, const std::vector<std::pair<std::string, bool>>& words, const std::string& standard);
  void note(const char* key, const std::string& type, const std::string& allowed = "", const std::string& unit = "",
            const std::string& standard = "");
  [[noreturn]] void fail(const yaml::Value& value, const std::string& key, const std::string& message) const;
  double read_number(const yaml::Value& value, const std::string& key, const char* range, const char* unit) const;
  int read_integer(const yaml::Value& value, const std::string& key, const char* range, const char* unit) const;
  template <class T, std::size_t N, class Read>
  void read_array(const char* key, std::array<T, N>& out, const std::string& expected, Read read);

  const yaml::Value& map_;
  Schema* schema_ = nullptr;
  std::string path_, folder_;
  std::set<std::string> required_, one_of_;
  std::vector<std::string> known_;     // in the order of reading
  std::string missing_key_, missing_;  // the first required key that is absent
  std::string failed_key_, failed_;    // the first failed check
};

}  // namespace drench
