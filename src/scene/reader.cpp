#include "scene/reader.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <filesystem>
#include <limits>
#include <optional>
#include <stdexcept>
#include <string_view>

namespace drench {

using yaml::Value;

namespace {

struct Range {
  double low = 0, high = 0;
  bool low_open = false, high_open = false;
  bool contains(double x) const { return (low_open ? x > low : x >= low) && (high_open ? x < high : x <= high); }
};

double bound(std::string_view text) {
  double value = 0;
  const auto [end, code] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (code != std::errc{} || end != text.data() + text.size()) throw std::logic_error("a range of the schema is wrong");
  return value;
}

/// "(0, 1]" as numbers.
Range parse_range(std::string_view text) {
  const std::size_t comma = text.find(", ");
  if (text.size() < 6 || comma == text.npos) throw std::logic_error("a range of the schema is wrong");
  return {bound(text.substr(1, comma - 1)), bound(text.substr(comma + 2, text.size() - comma - 3)), text.front() == '(',
          text.back() == ')'};
}

std::string with_unit(const std::string& range, const std::string& unit) {
  return unit == "1" ? range + " (no unit)" : range + " " + unit;
}

std::string joined(const std::vector<std::string>& words) {
  std::string all;
  for (const auto& word : words) all += (all.empty() ? "" : ", ") + word;
  return all;
}

/// Insertions, deletions, replacements and swaps of neighbours that turn a into b.
std::size_t edit_distance(const std::string& a, const std::string& b) {
  std::vector<std::vector<std::size_t>> d(a.size() + 1, std::vector<std::size_t>(b.size() + 1));
  for (std::size_t i = 0; i <= a.size(); ++i) {
    for (std::size_t j = 0; j <= b.size(); ++j) {
      if (i == 0 || j == 0) {
        d[i][j] = i + j;
        continue;
      }
      d[i][j] = std::min({d[i - 1][j] + 1, d[i][j - 1] + 1, d[i - 1][j - 1] + (a[i - 1] == b[j - 1] ? 0 : 1)});
      const bool swapped = i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1];
      if (swapped) d[i][j] = std::min(d[i][j], d[i - 2][j - 2] + 1);
    }
  }
  return d[a.size()][b.size()];
}

/// The known key that `key` was probably meant to be, "" if none is near.
std::string nearest(const std::string& key, const std::vector<std::string>& known) {
  if (key.size() > 64) return "";
  std::string best;
  std::size_t best_distance = std::numeric_limits<std::size_t>::max();
  for (const auto& word : known) {
    const std::size_t distance = edit_distance(key, word);
    const std::size_t near = std::max<std::size_t>(1, std::min(key.size(), word.size()) / 3);
    if (distance > near || distance >= best_distance) continue;
    best = word;
    best_distance = distance;
  }
  return best;
}

std::optional<double> to_double(const Value& value) {
  if (value.kind != Value::Kind::scalar || value.quoted) return {};
  std::string_view text = value.text;
  if (text.size() > 1 && text[0] == '+' && text[1] != '-') text.remove_prefix(1);
  if (text == ".inf" || text == ".Inf" || text == ".INF") return std::numeric_limits<double>::infinity();
  if (text == "-.inf" || text == "-.Inf" || text == "-.INF") return -std::numeric_limits<double>::infinity();
  if (text == ".nan" || text == ".NaN" || text == ".NAN") return std::numeric_limits<double>::quiet_NaN();
  double number = 0;
  const auto [end, code] = std::from_chars(text.data(), text.data() + text.size(), number);
  if (end != text.data() + text.size() || code == std::errc::invalid_argument) return {};
  // above the largest double, or below the smallest: neither can be kept
  if (code == std::errc::result_out_of_range) return std::numeric_limits<double>::quiet_NaN();
  return number;
}

}  // namespace

Section::Section(const Value& map, std::string path, std::string folder)
    : map_(map), path_(std::move(path)), folder_(std::move(folder)) {
  if (map.kind != Value::Kind::map) {
    throw SceneError(map.place.text(), fmt::format("{}: is {}; allowed: a map of keys and values",
                                                   path_.empty() ? "scene" : path_, map.shown()));
  }
}

namespace {
const Value empty_map = [] {
  Value value;
  value.kind = Value::Kind::map;
  return value;
}();
}  // namespace

Section::Section(Schema& schema, std::string path) : map_(empty_map), schema_(&schema), path_(std::move(path)) {}

void Section::note(const char* key, const std::string& type, const std::string& allowed, const std::string& unit,
                   const std::string& standard) {
  const SchemaKey::Need need = required_.count(key) != 0 ? SchemaKey::Need::required
                               : one_of_.count(key) != 0 ? SchemaKey::Need::one_of
                                                         : SchemaKey::Need::optional;
  schema_->keys.push_back({path_of(key), type, allowed, unit == "1" ? "" : unit, standard, need});
}

std::string Section::path_of(const std::string& key) const { return path_.empty() ? key : path_ + "." + key; }

void Section::fail(const Value& value, const std::string& key, const std::string& message) const {
  throw SceneError(value.place.text(), path_of(key) + ": " + message);
}

const Value* Section::take(const char* key, const std::string& expected) {
  known_.push_back(key);
  const Value* value = map_.find(key);
  if (!value && required_.count(key) != 0 && missing_key_.empty()) {
    missing_key_ = key;
    missing_ = expected;
  }
  return value;
}

double Section::read_number(const Value& value, const std::string& key, const char* range, const char* unit) const {
  const std::string allowed = with_unit(range, unit);
  const std::optional<double> number = to_double(value);
  if (!number) fail(value, key, fmt::format("{} is not a number; allowed: {}", value.shown(), allowed));
  if (parse_range(range).contains(*number)) return *number;  // never true of NaN
  const char* wrong = std::isfinite(*number) ? "is out of range" : "is not a finite double";
  fail(value, key, fmt::format("{} {}; allowed: {}", value.shown(), wrong, allowed));
}

int Section::read_integer(const Value& value, const std::string& key, const char* range, const char* unit) const {
  const std::string allowed = with_unit(range, unit);
  std::string_view text = value.text;
  int number = 0;
  const auto [end, code] = std::from_chars(text.data(), text.data() + text.size(), number);
  const bool whole = value.kind == Value::Kind::scalar && !value.quoted && end == text.data() + text.size();
  if (!whole || code == std::errc::invalid_argument) {
    fail(value, key, fmt::format("{} is not a whole number; allowed: {}", value.shown(), allowed));
  }
  if (code == std::errc{} && parse_range(range).contains(number)) return number;
  fail(value, key, fmt::format("{} is out of range; allowed: {}", value.shown(), allowed));
}

void Section::number(const char* key, double& out, const char* range, const char* unit) {
  if (schema_) return note(key, "number", range, unit, yaml::text(out));
  const Value* value = take(key, "a number in " + with_unit(range, unit));
  if (value) out = read_number(*value, key, range, unit);
}

void Section::number(const char* key, std::optional<double>& out, const char* range, const char* unit) {
  if (schema_) return note(key, "number", range, unit);
  double value = 0;
  number(key, value, range, unit);
  if (has(key)) out = value;
}

void Section::integer(const char* key, int& out, const char* range, const char* unit) {
  if (schema_) return note(key, "whole number", range, unit, yaml::text(out));
  const Value* value = take(key, "a whole number in " + with_unit(range, unit));
  if (value) out = read_integer(*value, key, range, unit);
}

template <class T, std::size_t N, class Read>
void Section::read_array(const char* key, std::array<T, N>& out, const std::string& expected, Read read) {
  const Value* value = take(key, expected);
  if (!value) return;
  if (value->kind != Value::Kind::list || value->items.size() != N) {
    fail(*value, key, fmt::format("is {}; allowed: {}", value->shown(), expected));
  }
  for (std::size_t i = 0; i < N; ++i) out[i] = read(value->items[i], fmt::format("{}.{}", key, i));
}

void Section::numbers(const char* key, Vec3& out, const char* range, const char* unit) {
  if (schema_) return note(key, "3 numbers", range, unit, yaml::text(out));
  read_array(key, out, "a list of 3 numbers in " + with_unit(range, unit),
             [&](const Value& item, const std::string& at) { return read_number(item, at, range, unit); });
}

void Section::numbers(const char* key, std::array<double, 2>& out, const char* range, const char* unit) {
  if (schema_) return note(key, "2 numbers", range, unit, yaml::text(out));
  read_array(key, out, "a list of 2 numbers in " + with_unit(range, unit),
             [&](const Value& item, const std::string& at) { return read_number(item, at, range, unit); });
}

void Section::integers(const char* key, std::array<int, 2>& out, const char* range, const char* unit) {
  if (schema_) return note(key, "2 whole numbers", range, unit, yaml::text(out));
  read_array(key, out, "a list of 2 whole numbers in " + with_unit(range, unit),
             [&](const Value& item, const std::string& at) { return read_integer(item, at, range, unit); });
}

void Section::integers(const char* key, std::vector<Index>& out, const char* range, const char* unit) {
  if (schema_) return note(key, "list of whole numbers", range, unit);
  const Value* value = take(key, "a list of whole numbers in " + with_unit(range, unit));
  if (!value) return;
  check_list(key, *value);
  out.clear();
  for (std::size_t i = 0; i < value->items.size(); ++i) {
    out.push_back(read_integer(value->items[i], fmt::format("{}.{}", key, i), range, unit));
  }
}

void Section::boolean(const char* key, bool& out) {
  if (schema_) return note(key, "switch", "true, false, on, off", "", out ? "true" : "false");
  const Value* value = take(key, "true or false");
  if (!value) return;
  const bool plain = value->kind == Value::Kind::scalar && !value->quoted;
  const bool yes = plain && (value->text == "true" || value->text == "on");
  if (!yes && !(plain && (value->text == "false" || value->text == "off"))) {
    fail(*value, key, fmt::format("{} is not a truth value; allowed: true, false, on, off", value->shown()));
  }
  out = yes;
}

bool Section::flag(const char* key) {
  if (schema_) {
    note(key, "switch", "true");
    return false;
  }
  bool on = true;
  const bool stands = has(key);
  boolean(key, on);
  check(on, key, "is false; allowed: true, or leave it out");
  return stands;
}

void Section::text(const char* key, std::string& out) {
  constexpr std::size_t max_length = 100;
  const std::string bytes = fmt::format("1 to {} bytes without control characters", max_length);
  if (schema_) return note(key, "text", bytes, "", out);
  const std::string expected = "a text of " + bytes;
  const Value* value = take(key, expected);
  if (!value) return;
  const bool clean = std::none_of(value->text.begin(), value->text.end(),
                                  [](char c) { return static_cast<unsigned char>(c) < 0x20 || c == 0x7f; });
  if (value->kind != Value::Kind::scalar || value->text.empty() || value->text.size() > max_length || !clean) {
    fail(*value, key, fmt::format("is {}; allowed: {}", value->shown(), expected));
  }
  out = value->text;
}

void Section::mesh_file(const char* key, std::string& out) {
  namespace fs = std::filesystem;
  if (schema_) return note(key, "file", ".obj, .ply, .stl");
  const std::string expected = "the name of an .obj, .ply or .stl file";
  const Value* value = take(key, expected);
  if (!value) return;
  const bool named = value->kind == Value::Kind::scalar && !value->text.empty();
  // a NUL byte would cut the name short in the system call
  if (!named || value->text.find('\0') != std::string::npos) {
    fail(*value, key, fmt::format("is {}; allowed: {}", value->shown(), expected));
  }
  std::string extension = fs::path(value->text).extension().string();
  for (char& c : extension) c = c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
  if (extension != ".obj" && extension != ".ply" && extension != ".stl") {
    fail(*value, key, fmt::format("{} is not a mesh file that can be read; allowed: .obj, .ply, .stl", value->shown()));
  }
  std::error_code error;
  const fs::path file = fs::absolute(fs::path(folder_) / value->text, error).lexically_normal();
  if (error || !fs::exists(file, error)) fail(*value, key, fmt::format("there is no file '{}'", file.string()));
  if (!fs::is_regular_file(file, error)) fail(*value, key, fmt::format("'{}' is not a file", file.string()));
  out = file.string();
}

int Section::word_index(const char* key, const std::vector<std::pair<std::string, bool>>& words,
                        const std::string& standard) {
  std::vector<std::string> allowed, all;
  for (const auto& [word, available] : words) {
    all.push_back(word);
    if (available) allowed.push_back(word);
  }
  if (schema_) {
    note(key, "word", joined(allowed), "", standard);
    return -1;
  }
  const Value* value = take(key, "one of " + joined(allowed));
  if (!value) return -1;
  for (std::size_t i = 0; i < words.size(); ++i) {
    if (value->kind != Value::Kind::scalar || value->text != words[i].first) continue;
    if (words[i].second) return static_cast<int>(i);
    fail(*value, key, fmt::format("{} is not available in this version; allowed: {}", value->shown(), joined(allowed)));
  }
  const std::string guess = value->kind == Value::Kind::scalar ? nearest(value->text, all) : "";
  const std::string hint = guess.empty() ? "" : fmt::format(" did you mean '{}'?", guess);
  fail(*value, key, fmt::format("{} is not known;{} allowed: {}", value->shown(), hint, joined(allowed)));
}

void Section::check_list(const char* key, const Value& value) const {
  if (value.kind != Value::Kind::list) fail(value, key, fmt::format("is {}; allowed: a list", value.shown()));
  if (value.items.empty()) fail(value, key, "is an empty list; allowed: at least one entry, or leave the key out");
}

std::string Section::one_of(std::initializer_list<const char*> keys, std::initializer_list<const char*> others) {
  if (schema_) {
    one_of_.insert(keys.begin(), keys.end());
    return "";
  }
  known_.assign(keys.begin(), keys.end());
  const std::vector<std::string> wanted = known_;
  known_.insert(known_.end(), others.begin(), others.end());
  check_known();
  std::vector<std::string> found;
  for (const yaml::Entry& entry : map_.entries)
    if (std::find(wanted.begin(), wanted.end(), entry.key) != wanted.end()) found.push_back(entry.key);
  if (found.size() == 1) return found.front();
  const std::string count = found.empty() ? "none" : std::to_string(found.size());
  throw SceneError(map_.place.text(), fmt::format("{}: has {} of the keys {}; allowed: exactly one of them", path_,
                                                  count, joined(wanted)));
}

void Section::check(bool good, const std::string& key, const std::string& message) {
  if (good || !failed_.empty()) return;
  failed_key_ = key;
  failed_ = message;
}

void Section::not_available(bool asked, const std::string& key, const std::string& feature,
                            const std::string& allowed) {
  check(!asked, key, fmt::format("{} is not available in this version; allowed: {}", feature, allowed));
}

void Section::check_known() const {
  for (const yaml::Entry& entry : map_.entries) {
    if (std::find(known_.begin(), known_.end(), entry.key) != known_.end()) continue;
    Value shown_key;
    shown_key.kind = Value::Kind::scalar;
    shown_key.text = entry.key;
    const std::string guess = nearest(entry.key, known_);
    const std::string hint =
        guess.empty() ? fmt::format("allowed: {}", joined(known_)) : fmt::format("did you mean '{}'?", guess);
    const std::string in = path_.empty() ? "the scene" : path_;
    throw SceneError(entry.place.text(), fmt::format("{}: unknown key {} in {}; {}", path_of(entry.key.substr(0, 64)),
                                                     shown_key.shown(), in, hint));
  }
}

void Section::done() const {
  check_known();
  if (!missing_key_.empty()) {
    throw SceneError(map_.place.text(), fmt::format("{}: is missing; allowed: {}", path_of(missing_key_), missing_));
  }
  if (!failed_.empty()) throw SceneError(map_.place_of(failed_key_).text(), path_of(failed_key_) + ": " + failed_);
}

}  // namespace drench
