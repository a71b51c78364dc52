#include "scene/yaml_tree.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>

#include "scene/scene_error.hpp"

namespace drench {

SceneError::SceneError(const std::string& where, const std::string& message)
    : std::runtime_error(yaml::escaped(where + ": " + message)) {}

namespace yaml {

namespace {

/// A value that came from --set has no line of its own.
void relocate(Value& value, const Place& place) {
  value.place = place;
  for (Value& item : value.items) relocate(item, place);
  for (Entry& entry : value.entries) {
    entry.place = place;
    relocate(entry.value, place);
  }
}

/// The value that `segment` names inside of `value`, made when it is a map's and missing.
Value& step_into(Value& value, const std::string& segment, const std::string& walked, const Place& place) {
  const std::string name = walked.empty() ? "scene" : walked;
  if (value.kind == Value::Kind::list) {
    std::size_t index = 0;
    const char* end = segment.data() + segment.size();
    const auto [stop, code] = std::from_chars(segment.data(), end, index);
    if (code != std::errc{} || stop != end || index >= value.items.size()) {
      throw SceneError(place.text(), fmt::format("{}: has no entry '{}'; allowed: 0 to {}", name, shortened(segment),
                                                 static_cast<long>(value.items.size()) - 1));
    }
    return value.items[index];
  }
  if (value.kind == Value::Kind::scalar) {
    throw SceneError(place.text(),
                     fmt::format("{}: has no key '{}', it is the value {}", name, shortened(segment), value.shown()));
  }
  if (value.kind == Value::Kind::null) {
    value.kind = Value::Kind::map;
    value.place = place;
  }
  for (Entry& entry : value.entries) {
    if (entry.key == segment) return entry.value;
  }
  value.entries.push_back({segment, place, {}});
  value.entries.back().value.place = place;
  return value.entries.back().value;
}

}  // namespace

std::string escaped(const std::string& text, std::string_view also) {
  std::string all;
  for (const char c : text) {
    const auto byte = static_cast<unsigned char>(c);
    if (also.find(c) != std::string_view::npos) all += '\\';
    if (byte < 0x20 || byte == 0x7f) {
      all += fmt::format("\\x{:02x}", byte);
    } else {
      all += c;
    }
  }
  return all;
}

std::string text(double x) { return std::isinf(x) ? (x > 0 ? ".inf" : "-.inf") : fmt::format("{}", x); }

std::string text(std::span<const double> values) {
  std::string all;
  for (const double value : values) all += (all.empty() ? "" : ", ") + text(value);
  return "[" + all + "]";
}

std::string shortened(const std::string& text) {
  constexpr std::size_t shown_length = 40;
  if (text.size() <= shown_length) return text;
  std::size_t end = shown_length;
  while (end > 0 && (static_cast<unsigned char>(text[end]) & 0xC0) == 0x80) --end;  // whole UTF-8 characters
  return text.substr(0, end) + "…";
}

std::string Place::text() const {
  const std::string name = source ? *source : "scene";
  return line > 0 ? fmt::format("{}:{}:{}", name, line, column) : name;
}

const Value* Value::find(const std::string& key) const {
  for (const Entry& entry : entries) {
    if (entry.key == key) return &entry.value;
  }
  return nullptr;
}

const Place& Value::place_of(const std::string& dotted) const {
  const Value* value = this;
  for (std::size_t begin = 0; begin < dotted.size();) {
    const std::size_t end = std::min(dotted.find('.', begin), dotted.size());
    const std::string segment = dotted.substr(begin, end - begin);
    const Value* next = nullptr;
    if (value->kind == Kind::map) {
      next = value->find(segment);
    } else if (value->kind == Kind::list) {
      const std::size_t index = std::stoul(segment);
      if (index < value->items.size()) next = &value->items[index];
    }
    if (!next) break;
    value = next;
    begin = end + 1;
  }
  return value->place;
}

std::string Value::shown() const {
  switch (kind) {
    case Kind::scalar:
      return fmt::format("'{}'", shortened(text));
    case Kind::list:
      return fmt::format("a list of {}", items.size());
    case Kind::map:
      return "a map";
    case Kind::null:
      break;
  }
  return "nothing";
}

void apply_override(Value& root, const std::string& override_text) {
  const Place place{std::make_shared<const std::string>("--set " + shortened(override_text)), 0, 0};
  const std::size_t equals = override_text.find('=');
  const std::string path = override_text.substr(0, equals);
  const bool bad_path = path.empty() || path.front() == '.' || path.back() == '.' || path.find("..") != path.npos;
  if (equals == std::string::npos || bad_path) {
    throw SceneError(place.text(), "cannot be understood; allowed: key.path=value");
  }
  Value value;
  try {
    value = parse(override_text.substr(equals + 1), "value");
  } catch (const SceneError& error) {
    throw SceneError(place.text(), fmt::format("{}: {}", path, error.what()));
  }
  relocate(value, place);
  Value* target = &root;
  std::string walked;
  std::size_t depth = 0;
  for (std::size_t begin = 0; begin <= path.size();) {
    const std::size_t end = std::min(path.find('.', begin), path.size());
    const std::string segment = path.substr(begin, end - begin);
    if (++depth > max_depth) throw SceneError(place.text(), fmt::format("{}: is too deep", shortened(path)));
    target = &step_into(*target, segment, walked, place);
    walked += walked.empty() ? segment : "." + segment;
    begin = end + 1;
  }
  *target = std::move(value);
}

}  // namespace yaml

}  // namespace drench
