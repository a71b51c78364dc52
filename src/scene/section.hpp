#pragma once
// A scene's sections, each described once. describe(Section&, T&) names every key of T with its range, unit and
// meaning; the default is the member's own. A scene is loaded, checked, saved and documented by that one description,
// each with a Section of its own (scene/section_modes.hpp). docs/dev/add_a_scene_key.md shows how to add a key.

#include <array>
#include <cstddef>
#include <functional>
#include <initializer_list>
#include <optional>
#include <span>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "base/keyed.hpp"
#include "base/types.hpp"

namespace drench {

class Section;
using Describe = std::function<void(Section&)>;

/// A value of an enumeration and its word in the scene file.
template <class T>
struct Word {
  const char* word;
  T value;
};

/// One map of a scene. Its keys are named in the order in which a resolved scene and scenes/README.md have them.
/// Ranges are written as in mathematics: "(0, 1]"; a closed end at inf admits infinity. Unit "1" is none; one in
/// brackets is for error messages alone. A meaning is one line of scenes/README.md.
class Section {
 public:
  virtual ~Section() = default;

  // ---- keys with a value
  virtual void number(const char* key, double& value, const char* range, const char* unit, const char* meaning) = 0;
  /// A number without a default: absent, it stays empty.
  virtual void number(const char* key, std::optional<double>& value, const char* range, const char* unit,
                      const char* meaning) = 0;
  /// A number, or one of the words for some of its values.
  virtual void number(const char* key, double& value, std::span<const Word<double>> words, const char* range,
                      const char* unit, const char* meaning) = 0;
  virtual void numbers(const char* key, std::span<double> values, const char* range, const char* unit,
                       const char* meaning) = 0;
  /// One that may move with time: as a plain value, as keys [[time, value], …], or as {keys: …, interpolation: …}.
  virtual void number(const char* key, Keyed<double>& value, const char* range, const char* unit,
                      const char* meaning) = 0;
  virtual void numbers(const char* key, Keyed<Vec3>& value, const char* range, const char* unit,
                       const char* meaning) = 0;
  virtual void integer(const char* key, int& value, const char* range, const char* unit, const char* meaning) = 0;
  virtual void integers(const char* key, std::span<int> values, const char* range, const char* unit,
                        const char* meaning) = 0;
  /// As many as stand there, at least one.
  virtual void integer_list(const char* key, std::vector<Index>& values, const char* range, const char* unit,
                            const char* meaning) = 0;
  /// [a, b] each, as many as stand there, at least one.
  virtual void integer_pairs(const char* key, std::vector<std::array<Index, 2>>& values, const char* range,
                             const char* unit, const char* meaning) = 0;
  virtual void boolean(const char* key, bool& value, const char* meaning) = 0;
  /// A boolean that a resolved scene has as on or off.
  virtual void on_off(const char* key, bool& value, const char* meaning) = 0;
  /// Just `key: true`.
  virtual void flag(const char* key, const char* meaning) = 0;
  /// Not empty, up to 100 bytes, no control characters.
  virtual void text(const char* key, std::string& value, const char* meaning) = 0;
  /// As many of them as there are values.
  virtual void texts(const char* key, std::span<std::string> values, const char* meaning) = 0;
  /// A file that exists; becomes an absolute path.
  virtual void other_file(const char* key, std::string& value, const char* meaning) = 0;
  /// A mesh file that exists; becomes an absolute path.
  virtual void mesh_file(const char* key, std::string& value, const char* meaning) = 0;

  /// Mesh files that exist, in their order: a list of names, a name with {} or {:04d} for consecutive numbers, or
  /// one with a *.
  virtual void mesh_files(const char* key, std::vector<std::string>& values, const char* meaning) = 0;
  /// The same, or a point cache, which moves one.
  virtual void moving_mesh(const char* key, std::vector<std::string>& values, const char* meaning) = 0;
  /// The same of other files.
  virtual void other_files(const char* key, std::vector<std::string>& values, const char* meaning) = 0;

  template <class T>
  void choice(const char* key, T& value, std::initializer_list<Word<std::type_identity_t<T>>> words,
              const char* meaning) {
    std::vector<const char*> names;
    std::size_t index = 0;
    for (const auto& word : words) {
      if (word.value == value) index = names.size();
      names.push_back(word.word);
    }
    value = std::data(words)[word_index(key, names, index, meaning)].value;
  }

  /// One of many words, kept as text; the first of them where it is none.
  void word(const char* key, std::string& value, const std::vector<const char*>& words, const char* meaning) {
    std::size_t index = 0;
    for (std::size_t i = 0; i < words.size(); ++i)
      if (value == words[i]) index = i;
    value = words[word_index(key, words, index, meaning)];
  }

  // ---- keys with a map
  template <class T>
  void section(const char* key, T& out, const char* meaning) {
    map(key, meaning, [&](Section& s) { describe(s, out); });
  }
  template <class T>
  void section(const char* key, T& out, void (*describe_part)(Section&, T&), const char* meaning) {
    map(key, meaning, [&](Section& s) { describe_part(s, out); });
  }
  template <class T>
  void section(const char* key, std::optional<T>& out, const char* meaning) {
    bool present = out.has_value();
    T value = out.value_or(T{});
    optional(present).section(key, value, meaning);
    if (present) out = std::move(value);
  }
  /// A list of maps that is not empty; saved unless `all` is empty.
  template <class T>
  void list(const char* key, std::vector<T>& all, const char* meaning) {
    maps(key, all.size(), meaning, [&](Section& s, std::size_t index) {
      if (index >= all.size()) all.resize(index + 1);
      describe(s, all[index]);
    });
  }

  /// The same; entries begin as copies of `standard`.
  template <class T>
  void list(const char* key, std::vector<T>& all, const T& standard, const char* meaning) {
    maps(key, all.size(), meaning, [&](Section& s, std::size_t index) {
      if (index >= all.size()) all.resize(index + 1, standard);
      describe(s, all[index]);
    });
  }

  // ---- of the key that follows: s.required().number(…)
  Section& required() {
    said_.required = true;
    return *this;
  }
  /// Exactly one of the keys of this map that are so must stand in it.
  Section& one_of() {
    said_.one_of = true;
    return *this;
  }
  /// The same, where `kind` says which of them it is: `value` for this one.
  template <class T>
  Section& one_of(T& kind, T value) {
    said_.on_found = [&kind, value] { kind = value; };
    return one_of().saved_if(kind == value);
  }
  /// It is saved only if it is `present`, and sets that when it is loaded.
  Section& optional(bool& present) {
    said_.on_found = [&present] { present = true; };
    return saved_if(present);
  }
  Section& saved_if(bool condition) {
    said_.saved = said_.saved && condition;
    return *this;
  }

  // ---- of the map
  /// A resolved scene has this map on one line: {a: 1, b: 2}.
  virtual void one_line() {}
  /// Behind the last key of this map in a resolved scene, in place of its unit.
  virtual void remark(const char*) {}
  /// Does the key stand in the scene that is being loaded?
  virtual bool has(const char*) const { return false; }
  /// A relation between keys. If it is not `good`, loading refuses the map with `message` at `key` (dotted, from here).
  virtual void check(bool /*good*/, const std::string& /*key*/, const std::string& /*message*/) {}
  /// A key that stands elsewhere in a scene and not in this map. Loading refuses it with `message`.
  virtual void not_here(const char* /*key*/, const char* /*message*/) {}
  /// A feature that the format has words for and this version lacks.
  void not_available(bool asked, const std::string& key, const std::string& feature, const std::string& allowed) {
    check(!asked, key, feature + " is not available in this version; allowed: " + allowed);
  }

 protected:
  /// The properties of the key that follows.
  struct Said {
    bool required = false, one_of = false, saved = true;
    std::function<void()> on_found;
  };
  /// Every mode asks for it once a key.
  Said take_said() { return std::exchange(said_, {}); }

  virtual std::size_t word_index(const char* key, const std::vector<const char*>& words, std::size_t index,
                                 const char* meaning) = 0;
  virtual void map(const char* key, const char* meaning, const Describe& inside) = 0;
  virtual void maps(const char* key, std::size_t count, const char* meaning,
                    const std::function<void(Section&, std::size_t)>& entry) = 0;

 private:
  Said said_;
};

}  // namespace drench
