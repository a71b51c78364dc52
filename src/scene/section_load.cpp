// Loading: a Section that reads a map of the scene file, checks every value, and says where a bad one stands.

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "scene/file_name.hpp"
#include "scene/nearest_word.hpp"
#include "scene/scalars.hpp"
#include "scene/scene_error.hpp"
#include "scene/section_modes.hpp"
#include "scene/sequence_names.hpp"

namespace drench {

using yaml::Value;

namespace {

std::string with_unit(const std::string& range, const std::string& unit) {
  return unit == "1" ? range + " (no unit)" : range + " " + unit;
}

class LoadSection : public Section {
 public:
  /// `path` is the map's key path, "" for the root.
  LoadSection(const Value& map, std::string path, const std::string& folder, const LoadSection* around = nullptr);

  void number(const char* key, double& value, const char* range, const char* unit, const char*) override {
    if (const Value* found = take(key, "a number in " + with_unit(range, unit)))
      value = read_number(*found, key, range, unit);
  }
  void number(const char* key, std::optional<double>& value, const char* range, const char* unit,
              const char*) override {
    if (const Value* found = take(key, "a number in " + with_unit(range, unit)))
      value = read_number(*found, key, range, unit);
  }
  void number(const char* key, double& value, std::span<const Word<double>> words, const char* range, const char* unit,
              const char*) override;
  void number(const char* key, Keyed<double>& value, const char* range, const char* unit, const char*) override;
  void numbers(const char* key, Keyed<Vec3>& value, const char* range, const char* unit, const char*) override;
  void integer(const char* key, int& value, const char* range, const char* unit, const char*) override {
    if (const Value* found = take(key, "a whole number in " + with_unit(range, unit)))
      value = read_integer(*found, key, range, unit);
  }
  void numbers(const char* key, std::span<double> values, const char* range, const char* unit, const char*) override {
    const std::string expected = fmt::format("a list of {} numbers in {}", values.size(), with_unit(range, unit));
    if (const Value* found = take_array(key, values.size(), expected))
      for (std::size_t i = 0; i < values.size(); ++i)
        values[i] = read_number(found->items[i], fmt::format("{}.{}", key, i), range, unit);
  }
  void integers(const char* key, std::span<int> values, const char* range, const char* unit, const char*) override {
    const std::string expected = fmt::format("a list of {} whole numbers in {}", values.size(), with_unit(range, unit));
    if (const Value* found = take_array(key, values.size(), expected))
      for (std::size_t i = 0; i < values.size(); ++i)
        values[i] = read_integer(found->items[i], fmt::format("{}.{}", key, i), range, unit);
  }
  void integer_list(const char* key, std::vector<Index>& values, const char* range, const char* unit,
                    const char*) override;
  void integer_pairs(const char* key, std::vector<std::array<Index, 2>>& values, const char* range, const char* unit,
                     const char*) override;
  void boolean(const char* key, bool& value, const char*) override;
  void on_off(const char* key, bool& value, const char* meaning) override { boolean(key, value, meaning); }
  void flag(const char* key, const char* meaning) override {
    bool on = true;
    boolean(key, on, meaning);
    check(on, key, "is false; allowed: true, or leave it out");
  }
  void text(const char* key, std::string& value, const char*) override;
  void texts(const char* key, std::span<std::string> values, const char*) override;
  void other_file(const char* key, std::string& value, const char*) override;
  void mesh_file(const char* key, std::string& value, const char*) override;
  void mesh_files(const char* key, std::vector<std::string>& values, const char*) override {
    files(key, values, mesh_files_allowed, FileKind::mesh);
  }
  void moving_mesh(const char* key, std::vector<std::string>& values, const char*) override {
    files(key, values, moving_mesh_allowed, FileKind::mesh_or_point_cache);
  }
  void other_files(const char* key, std::vector<std::string>& values, const char*) override {
    files(key, values, other_files_allowed, FileKind::any);
  }

  bool has(const char* key) const override { return map_.find(key) != nullptr; }
  void check(bool good, const std::string& key, const std::string& message) override {
    if (good || !failed_.empty()) return;
    failed_key_ = key;
    failed_ = message;
  }

  void not_here(const char* key, const char* message) override { check(!has(key), key, message); }

  /// Reads the whole map. Which of several keys stands there is settled first: a wrong value may be one too many.
  void read(const Describe& inside) {
    inside_ = &inside;
    const Schema schema = document_section(inside, false);
    for (const SchemaKey& key : schema.keys) {
      known_.push_back(key.path);
      if (key.need == SchemaKey::Need::one_of) one_of_.push_back(key.path);
    }
    elsewhere_ = schema.elsewhere;
    if (!one_of_.empty()) check_one_of();
    inside(*this);
    done();
  }

 protected:
  std::size_t word_index(const char* key, const std::vector<const char*>& words, std::size_t index,
                         const char*) override;
  void map(const char* key, const char*, const Describe& inside) override;
  void maps(const char* key, std::size_t, const char*,
            const std::function<void(Section&, std::size_t)>& entry) override;

 private:
  std::string path_of(const std::string& key) const { return path_.empty() ? key : path_ + "." + key; }
  [[noreturn]] void fail(const Value& value, const std::string& key, const std::string& message) const {
    throw SceneError(value.place.text(), path_of(key) + ": " + message);
  }
  const Value* take(const char* key, const std::string& expected);
  const Value* take_array(const char* key, std::size_t size, const std::string& expected);
  double read_number(const Value& value, const std::string& key, const char* range, const char* unit) const;
  int read_integer(const Value& value, const std::string& key, const char* range, const char* unit) const;
  std::string read_text(const Value& value, const std::string& key) const;
  void files(const char* key, std::vector<std::string>& values, const char* allowed, FileKind kind);
  std::string read_file_name(const Value& value, const std::string& key, FileKind kind) const;
  Vec3 read_vector(const Value& value, const std::string& key, const char* range, const char* unit) const;
  template <class T, class Read>
  void read_keyed(const char* key, Keyed<T>& value, const std::string& expected, Read read);
  template <class T, class Read>
  Keyed<T> read_keys(const Value& list, const std::string& key, Interpolation interpolation,
                     const std::string& expected, Read read) const;
  void check_list(const std::string& key, const Value& value) const;
  void check_known() const;
  /// Where a key that is unknown here is known, in a map here or in the one around this; "" if nowhere.
  std::string place_of_key(const std::string& key) const;
  void check_one_of() const;
  void done() const;

  const Value& map_;
  std::string path_;
  const std::string& folder_;
  const LoadSection* around_;           // the map that this one is in
  const Describe* inside_ = nullptr;    // what is read; null for the keys of a value, which hold no maps
  std::vector<std::string> known_;      // its keys
  std::vector<std::string> elsewhere_;  // keys that are refused with a message of their own
  std::vector<std::string> one_of_;     // of these, exactly one
  std::string missing_key_, missing_;   // the first required key that is absent
  std::string failed_key_, failed_;     // the first failed check
};

LoadSection::LoadSection(const Value& map, std::string path, const std::string& folder, const LoadSection* around)
    : map_(map), path_(std::move(path)), folder_(folder), around_(around) {
  if (map.kind == Value::Kind::map) return;
  throw SceneError(map.place.text(), fmt::format("{}: is {}; allowed: a map of keys and values",
                                                 path_.empty() ? "scene" : path_, map.shown()));
}

const Value* LoadSection::take(const char* key, const std::string& expected) {
  const Said said = take_said();
  const Value* value = map_.find(key);
  if (value && said.on_found) said.on_found();
  if (!value && said.required && missing_key_.empty()) {
    missing_key_ = key;
    missing_ = expected;
  }
  return value;
}

const Value* LoadSection::take_array(const char* key, std::size_t size, const std::string& expected) {
  const Value* value = take(key, expected);
  if (value && (value->kind != Value::Kind::list || value->items.size() != size))
    fail(*value, key, fmt::format("is {}; allowed: {}", value->shown(), expected));
  return value;
}

namespace {

/// "… is not a number". `kind`: what it is not.
std::string not_a(const char* kind, const Value& value) {
  Value plain = value;
  plain.quoted = false;
  if (value.quoted && to_double(plain))
    return fmt::format("{} in quotes is not {}: remove the quotes", value.shown(), kind);
  return fmt::format("{} is not {}", value.shown(), kind);
}

}  // namespace

double LoadSection::read_number(const Value& value, const std::string& key, const char* range, const char* unit) const {
  const std::string allowed = with_unit(range, unit);
  const std::optional<double> number = to_double(value);
  if (!number) fail(value, key, fmt::format("{}; allowed: {}", not_a("a number", value), allowed));
  if (parse_range(range).contains(*number)) return *number;  // never true of NaN
  const char* wrong = std::isfinite(*number) ? "is out of range" : "is not a finite double";
  fail(value, key, fmt::format("{} {}; allowed: {}", value.shown(), wrong, allowed));
}

int LoadSection::read_integer(const Value& value, const std::string& key, const char* range, const char* unit) const {
  const std::string allowed = with_unit(range, unit);
  bool whole = false;
  const std::optional<int> number = to_int(value, whole);
  if (!whole) fail(value, key, fmt::format("{}; allowed: {}", not_a("a whole number", value), allowed));
  if (number && parse_range(range).contains(*number)) return *number;
  fail(value, key, fmt::format("{} is out of range; allowed: {}", value.shown(), allowed));
}

void LoadSection::number(const char* key, double& value, std::span<const Word<double>> words, const char* range,
                         const char* unit, const char*) {
  const std::string allowed = with_unit(words_or(words, range), unit);
  const Value* found = take(key, allowed);
  if (!found) return;
  const bool scalar = found->kind == Value::Kind::scalar;
  for (const Word<double>& word : words) {
    if (!scalar || found->text != word.word) continue;
    value = word.value;
    return;
  }
  const std::optional<double> number = to_double(*found);
  if (!number)
    fail(*found, key, fmt::format("{} is neither one of its words nor a number; allowed: {}", found->shown(), allowed));
  if (!parse_range(range).contains(*number))
    fail(*found, key, fmt::format("{} is out of range; allowed: {}", found->shown(), allowed));
  value = *number;
}

Vec3 LoadSection::read_vector(const Value& value, const std::string& key, const char* range, const char* unit) const {
  if (value.kind != Value::Kind::list || value.items.size() != 3)
    fail(value, key,
         fmt::format("is {}; allowed: {}", value.shown(), "a list of 3 numbers in " + with_unit(range, unit)));
  Vec3 vector;
  for (std::size_t a = 0; a < 3; ++a)
    vector[a] = read_number(value.items[a], fmt::format("{}.{}", key, a), range, unit);
  return vector;
}

/// `read(section, value, key)` reads a plain value. Only keys are a list of lists, or a map.
template <class T, class Read>
void LoadSection::read_keyed(const char* key, Keyed<T>& value, const std::string& expected, Read read) {
  const Value* found = take(key, expected);
  if (!found) return;
  if (found->kind == Value::Kind::map) {
    LoadSection sub(*found, path_of(key), folder_, this);
    sub.known_ = {"keys", "interpolation"};
    Interpolation between = Interpolation::linear;
    sub.choice("interpolation", between, interpolation_words, "");
    sub.required();
    const Value* keys = sub.take("keys", keys_allowed);
    sub.done();
    value = sub.read_keys<T>(*keys, "keys", between, expected, read);
  } else if (found->kind == Value::Kind::list && !found->items.empty() && found->items[0].kind == Value::Kind::list) {
    value = read_keys<T>(*found, key, Interpolation::linear, expected, read);
  } else {
    value = read(*this, *found, key);
  }
}

template <class T, class Read>
Keyed<T> LoadSection::read_keys(const Value& list, const std::string& key, Interpolation interpolation,
                                const std::string& expected, Read read) const {
  check_list(key, list);
  std::vector<Key<T>> keys;
  for (std::size_t i = 0; i < list.items.size(); ++i) {
    const Value& item = list.items[i];
    const std::string name = fmt::format("{}.{}", key, i), time = name + ".0";
    if (item.kind != Value::Kind::list || item.items.size() != 2)
      fail(item, name, fmt::format("is {}; allowed: [time, value], the value {}", item.shown(), expected));
    Key<T> next{read_number(item.items[0], time, key_time_range, "s"), read(*this, item.items[1], name + ".1")};
    if (!keys.empty() && !(keys.back().time < next.time))
      fail(item.items[0], time,
           fmt::format("{} is not later than the previous entry ({}); allowed: a larger value, in s",
                       item.items[0].shown(), keys.back().time));
    keys.push_back(std::move(next));
  }
  return Keyed<T>(std::move(keys), interpolation);
}

void LoadSection::number(const char* key, Keyed<double>& value, const char* range, const char* unit, const char*) {
  read_keyed(key, value, "a number in " + with_unit(range, unit),
             [=](const LoadSection& s, const Value& found, const std::string& name) {
               return s.read_number(found, name, range, unit);
             });
}

void LoadSection::numbers(const char* key, Keyed<Vec3>& value, const char* range, const char* unit, const char*) {
  read_keyed(key, value, "a list of 3 numbers in " + with_unit(range, unit),
             [=](const LoadSection& s, const Value& found, const std::string& name) {
               return s.read_vector(found, name, range, unit);
             });
}

void LoadSection::integer_list(const char* key, std::vector<Index>& values, const char* range, const char* unit,
                               const char*) {
  const Value* found = take(key, "a list of whole numbers in " + with_unit(range, unit));
  if (!found) return;
  check_list(key, *found);
  values.clear();
  for (std::size_t i = 0; i < found->items.size(); ++i)
    values.push_back(read_integer(found->items[i], fmt::format("{}.{}", key, i), range, unit));
}

void LoadSection::integer_pairs(const char* key, std::vector<std::array<Index, 2>>& values, const char* range,
                                const char* unit, const char*) {
  const Value* found = take(key, "a list of pairs [a, b] of whole numbers in " + with_unit(range, unit));
  if (!found) return;
  check_list(key, *found);
  values.clear();
  for (std::size_t i = 0; i < found->items.size(); ++i) {
    const Value& item = found->items[i];
    const std::string name = fmt::format("{}.{}", key, i);
    if (item.kind != Value::Kind::list || item.items.size() != 2)
      fail(item, name,
           fmt::format("is {}; allowed: [a, b], two whole numbers in {}", item.shown(), with_unit(range, unit)));
    values.push_back(
        {read_integer(item.items[0], name + ".0", range, unit), read_integer(item.items[1], name + ".1", range, unit)});
  }
}

void LoadSection::texts(const char* key, std::span<std::string> values, const char*) {
  const Value* found = take_array(key, values.size(), fmt::format("a list of {} texts", values.size()));
  for (std::size_t i = 0; found && i < values.size(); ++i)
    values[i] = read_text(found->items[i], fmt::format("{}.{}", key, i));
}

void LoadSection::boolean(const char* key, bool& value, const char*) {
  const Value* found = take(key, "true or false");
  if (!found) return;
  const bool plain = found->kind == Value::Kind::scalar && !found->quoted;
  const bool yes = plain && (found->text == "true" || found->text == "on");
  if (!yes && !(plain && (found->text == "false" || found->text == "off")))
    fail(*found, key, fmt::format("{} is not a truth value; allowed: {}", found->shown(), switch_allowed));
  value = yes;
}

std::string LoadSection::read_text(const Value& value, const std::string& key) const {
  const bool clean = std::none_of(value.text.begin(), value.text.end(),
                                  [](char c) { return static_cast<unsigned char>(c) < 0x20 || c == 0x7f; });
  if (value.kind != Value::Kind::scalar || value.text.empty() || value.text.size() > text_max_length || !clean)
    fail(value, key, fmt::format("is {}; allowed: a text of {}", value.shown(), text_allowed));
  return value.text;
}

void LoadSection::text(const char* key, std::string& value, const char*) {
  if (const Value* found = take(key, fmt::format("a text of {}", text_allowed))) value = read_text(*found, key);
}

void LoadSection::mesh_file(const char* key, std::string& value, const char*) {
  if (const Value* found = take(key, mesh_name_expected)) value = read_file_name(*found, key, FileKind::mesh);
}

void LoadSection::other_file(const char* key, std::string& value, const char*) {
  if (const Value* found = take(key, "the name of a file")) value = read_file_name(*found, key, FileKind::any);
}

void LoadSection::files(const char* key, std::vector<std::string>& values, const char* allowed, FileKind kind) {
  const Value* found = take(key, allowed);
  if (!found) return;
  values.clear();
  if (found->kind == Value::Kind::list) {
    check_list(key, *found);
    for (std::size_t i = 0; i < found->items.size(); ++i)
      values.push_back(read_file_name(found->items[i], fmt::format("{}.{}", key, i), kind));
    return;
  }
  if (found->kind != Value::Kind::scalar || found->text.find('\0') != std::string::npos)
    fail(*found, key, fmt::format("is {}; allowed: {}", found->shown(), allowed));
  Value name = *found;
  const auto [names, problem] = sequence_names(found->text, folder_);
  if (!problem.empty()) fail(*found, key, fmt::format("{} {}", found->shown(), problem));
  for (const std::string& file : names) {
    name.text = file;
    values.push_back(read_file_name(name, key, kind));
  }
  if (values.empty())
    fail(*found, key, fmt::format("{} matches no existing file; allowed: {}", found->shown(), allowed));
}

std::string LoadSection::read_file_name(const Value& value, const std::string& key, FileKind kind) const {
  FoundFile found = find_file(value, folder_, kind);
  if (!found.problem.empty()) fail(value, key, found.problem);
  return std::move(found.path);
}

std::size_t LoadSection::word_index(const char* key, const std::vector<const char*>& words, std::size_t index,
                                    const char*) {
  const std::string allowed = fmt::format("{}", fmt::join(words, ", "));
  const Value* found = take(key, "one of " + allowed);
  if (!found) return index;
  const bool scalar = found->kind == Value::Kind::scalar;
  for (std::size_t i = 0; i < words.size(); ++i)
    if (scalar && found->text == words[i]) return i;
  const std::string guess = scalar ? nearest_word(found->text, {words.begin(), words.end()}) : "";
  const std::string hint = guess.empty() ? "" : fmt::format(" did you mean '{}'?", guess);
  fail(*found, key, fmt::format("{} is not known;{} allowed: {}", found->shown(), hint, allowed));
}

void LoadSection::map(const char* key, const char*, const Describe& inside) {
  const Value* found = take(key, "a map");
  if (!found) return;
  LoadSection(*found, path_of(key), folder_, this).read(inside);
}

void LoadSection::maps(const char* key, std::size_t, const char*,
                       const std::function<void(Section&, std::size_t)>& entry) {
  const Value* found = take(key, "a list of maps");
  if (!found) return;
  check_list(key, *found);
  for (std::size_t i = 0; i < found->items.size(); ++i) {
    LoadSection item(found->items[i], path_of(key) + "." + std::to_string(i), folder_, this);
    item.read([&](Section& s) { entry(s, i); });
  }
}

void LoadSection::check_list(const std::string& key, const Value& value) const {
  if (value.kind != Value::Kind::list) fail(value, key, fmt::format("is {}; allowed: a list", value.shown()));
  if (value.items.empty()) fail(value, key, "is an empty list; allowed: at least one entry, or leave the key out");
}

std::string LoadSection::place_of_key(const std::string& key) const {
  const Schema deep = inside_ ? document_section(*inside_) : Schema();
  for (const yaml::Entry& entry : map_.entries)
    if (const std::string path = entry.key + "." + key; deep.find(path)) return path_of(path);
  if (around_ && std::find(around_->known_.begin(), around_->known_.end(), key) != around_->known_.end())
    return around_->path_of(key);
  // In a map beside this one, such as `place` beside `mesh`, unless only one of the two may be there.
  const Schema beside = around_ && around_->inside_ ? document_section(*around_->inside_) : Schema();
  for (const std::string& map : around_ ? around_->known_ : std::vector<std::string>()) {
    const bool other_kind = std::find(around_->one_of_.begin(), around_->one_of_.end(), map) != around_->one_of_.end();
    if (const std::string path = map + "." + key; !other_kind && beside.find(path)) return around_->path_of(path);
  }
  return "";
}

/// The first of some words, as many as fit in a line.
std::string first_words(const std::vector<std::string>& words) {
  constexpr std::size_t most = 220;  // bytes
  std::string line;
  for (std::size_t k = 0; k < words.size(); ++k) {
    if (line.size() + words[k].size() > most)
      return line + fmt::format(" and {} more (drench schema)", words.size() - k);
    line += (k > 0 ? ", " : "") + words[k];
  }
  return line;
}

void LoadSection::check_known() const {
  for (const yaml::Entry& entry : map_.entries) {
    if (std::find(known_.begin(), known_.end(), entry.key) != known_.end()) continue;
    if (std::find(elsewhere_.begin(), elsewhere_.end(), entry.key) != elsewhere_.end()) continue;
    Value shown_key;
    shown_key.kind = Value::Kind::scalar;
    shown_key.text = entry.key;
    const std::string guess = nearest_word(entry.key, known_), place = place_of_key(entry.key);
    const std::string hint = entry.key == "<<" ? "merge keys are not supported: repeat the keys"
                             : !place.empty()  ? fmt::format("did you mean {}?", place)
                             : !guess.empty()  ? fmt::format("did you mean '{}'?", guess)
                                               : "allowed: " + first_words(known_);
    throw SceneError(entry.place.text(), fmt::format("{}: unknown key {} in {}; {}", path_of(entry.key.substr(0, 64)),
                                                     shown_key.shown(), path_.empty() ? "the scene" : path_, hint));
  }
}

void LoadSection::check_one_of() const {
  check_known();
  const auto found = std::count_if(one_of_.begin(), one_of_.end(), [&](const auto& key) { return map_.find(key); });
  if (found == 1) return;
  throw SceneError(
      map_.place.text(),
      fmt::format("{}: has {} of the keys {}; allowed: exactly one of them", path_.empty() ? "scene" : path_,
                  found == 0 ? "none" : std::to_string(found), fmt::join(one_of_, ", ")));
}

/// Throws the first complaint that waited.
void LoadSection::done() const {
  check_known();
  if (!missing_key_.empty())
    throw SceneError(map_.place.text(), fmt::format("{}: is missing; allowed: {}", path_of(missing_key_), missing_));
  if (!failed_.empty()) throw SceneError(map_.place_of(failed_key_).text(), path_of(failed_key_) + ": " + failed_);
}

}  // namespace

void load_section(const Value& map, const std::string& folder, const Describe& describe) {
  LoadSection(map, "", folder).read(describe);
}

}  // namespace drench
