// YAML text → tree, by the events of yaml-cpp.

#include <fmt/format.h>
#include <yaml-cpp/eventhandler.h>
#include <yaml-cpp/exceptions.h>
#include <yaml-cpp/parser.h>

#include <algorithm>
#include <map>
#include <sstream>
#include <string_view>

#include "scene/scene_error.hpp"
#include "scene/yaml_tree.hpp"

namespace drench::yaml {

namespace {

[[noreturn]] void too_deep(const Place& where) {
  throw SceneError(where.text(), fmt::format("syntax: nested too deeply; allowed: {} levels", max_depth));
}

/// Whether the quoted scalar at `mark` ends with its quote; yaml-cpp lets the end of the file close it.
bool is_closed(const std::string& yaml, const YAML::Mark& mark) {
  constexpr const char* blanks = " \t\r\n";
  std::size_t at = static_cast<std::size_t>(mark.pos);
  while (at < yaml.size() && (yaml[at] == '&' || yaml[at] == '!')) {  // an anchor or tag stands before it
    at = yaml.find_first_not_of(blanks, yaml.find_first_of(blanks, at));
  }
  if (at >= yaml.size() || (yaml[at] != '"' && yaml[at] != '\'')) return true;  // a block scalar
  const char quote = yaml[at++];
  for (; at < yaml.size(); ++at) {
    if (quote == '"' && yaml[at] == '\\') {
      ++at;
    } else if (yaml[at] == quote) {
      if (quote == '"' || at + 1 >= yaml.size() || yaml[at + 1] != quote) return true;
      ++at;  // '' is a quote within quotes
    }
  }
  return false;
}

/// Builds the tree from yaml-cpp's events, so that the limits hold before memory is spent.
class TreeBuilder : public YAML::EventHandler {
 public:
  TreeBuilder(const std::string& yaml, std::shared_ptr<const std::string> source)
      : yaml_(yaml), source_(std::move(source)) {}

  void OnDocumentStart(const YAML::Mark& mark) override {
    if (documents_++ > 0) throw SceneError(place(mark).text(), "syntax: a second document; allowed: one per file");
  }
  void OnDocumentEnd() override {}
  void OnNull(const YAML::Mark& mark, YAML::anchor_t anchor) override {
    Value value;
    value.place = place(mark);
    add(std::move(value), anchor);
  }
  void OnAlias(const YAML::Mark& mark, YAML::anchor_t anchor) override {
    const auto found = anchored_.find(anchor);
    if (found == anchored_.end()) throw SceneError(place(mark).text(), "syntax: an alias inside of its own anchor");
    const auto& [value, size, height] = found->second;
    if (open_.size() + height > max_depth) too_deep(place(mark));
    count(size, place(mark));
    add_counted(value, 0, size, height);
  }
  void OnScalar(const YAML::Mark& mark, const std::string& tag, YAML::anchor_t anchor,
                const std::string& text) override {
    Value value;
    value.kind = Value::Kind::scalar;
    value.quoted = tag == "!";  // yaml-cpp's way to say so; a plain scalar has the tag "?"
    value.text = text;
    value.place = place(mark);
    if (!value.quoted) refuse_tag(tag, value.place);
    if (value.quoted && !is_closed(yaml_, mark)) {
      throw SceneError(value.place.text(), "syntax: a quote that is never closed");
    }
    add(std::move(value), anchor);
  }
  void OnSequenceStart(const YAML::Mark& mark, const std::string& tag, YAML::anchor_t anchor,
                       YAML::EmitterStyle::value) override {
    open(Value::Kind::list, mark, tag, anchor);
  }
  void OnSequenceEnd() override { close(); }
  void OnMapStart(const YAML::Mark& mark, const std::string& tag, YAML::anchor_t anchor,
                  YAML::EmitterStyle::value) override {
    open(Value::Kind::map, mark, tag, anchor);
  }
  void OnMapEnd() override { close(); }

  Value take_root() { return std::move(root_); }
  bool empty() const { return documents_ == 0; }

 private:
  struct Open {
    Value value;
    YAML::anchor_t anchor = 0;
    bool has_key = false;  // of a map: the last entry still waits for its value
    std::size_t size = 1;  // values in it, itself included
    std::size_t height = 1;
  };
  struct Anchored {
    Value value;
    std::size_t size, height;
  };

  Place place(const YAML::Mark& mark) const {
    if (mark.is_null()) return {source_, 1, 1};
    return {source_, mark.line + 1, mark.column + 1};
  }
  static void refuse_tag(const std::string& tag, const Place& where) {
    if (tag.empty() || tag == "?") return;
    throw SceneError(where.text(), fmt::format("syntax: the tag {}; allowed: no tags", shortened(tag)));
  }
  void count(std::size_t values, const Place& where) {
    values_ += values;
    if (values_ <= max_values) return;
    throw SceneError(where.text(), fmt::format("syntax: too many values; allowed: {} in one file", max_values));
  }
  void open(Value::Kind kind, const YAML::Mark& mark, const std::string& tag, YAML::anchor_t anchor) {
    Open frame;
    frame.value.kind = kind;
    frame.value.place = place(mark);
    frame.anchor = anchor;
    refuse_tag(tag == "!" ? "" : tag, frame.value.place);
    if (open_.size() >= max_depth) too_deep(frame.value.place);
    count(1, frame.value.place);
    open_.push_back(std::move(frame));
  }
  void close() {
    Open frame = std::move(open_.back());
    open_.pop_back();
    add_counted(std::move(frame.value), frame.anchor, frame.size, frame.height);
  }
  void add(Value value, YAML::anchor_t anchor) {
    count(1, value.place);
    add_counted(std::move(value), anchor, 1, 0);
  }
  void add_counted(Value value, YAML::anchor_t anchor, std::size_t size, std::size_t height) {
    if (anchor != 0) anchored_.insert_or_assign(anchor, Anchored{value, size, height});
    if (open_.empty()) {
      root_ = std::move(value);
      return;
    }
    Open& parent = open_.back();
    parent.size += size;
    parent.height = std::max(parent.height, height + 1);
    if (parent.value.kind == Value::Kind::list) {
      parent.value.items.push_back(std::move(value));
    } else if (parent.has_key) {
      Entry& entry = parent.value.entries.back();
      if (value.kind == Value::Kind::null) value.place = entry.place;  // nothing stands there: point to the key
      entry.value = std::move(value);
      parent.has_key = false;
    } else {
      add_key(parent, std::move(value));
    }
  }
  /// The key path of the map that is being read, with a dot behind it.
  std::string open_path() const {
    std::string path;
    for (std::size_t i = 0; i + 1 < open_.size(); ++i) {
      const Value& value = open_[i].value;
      if (value.kind == Value::Kind::map && !open_[i].has_key) continue;  // a map that stands as a key
      path +=
          value.kind == Value::Kind::list ? std::to_string(value.items.size()) : shortened(value.entries.back().key);
      path += '.';
    }
    return path;
  }
  void add_key(Open& map, Value key) {
    const std::string where = key.place.text();
    if (key.kind != Value::Kind::scalar) throw SceneError(where, "syntax: a key that is not a word");
    for (const Entry& entry : map.value.entries) {
      if (entry.key != key.text) continue;
      throw SceneError(where, fmt::format("{}{}: is given twice, first at line {}, column {}; allowed: once",
                                          open_path(), shortened(key.text), entry.place.line, entry.place.column));
    }
    if (map.value.entries.size() >= max_map_keys) {
      throw SceneError(where, fmt::format("syntax: too many keys; allowed: {} in one map", max_map_keys));
    }
    map.value.entries.push_back({std::move(key.text), key.place, {}});
    map.has_key = true;
  }

  const std::string& yaml_;
  std::shared_ptr<const std::string> source_;
  std::vector<Open> open_;
  std::map<YAML::anchor_t, Anchored> anchored_;
  Value root_;
  std::size_t values_ = 0;
  int documents_ = 0;
};

/// Refuses text that yaml-cpp lets through or stumbles over: tabs that indent, control characters (0x04 silently ends
/// its input), other encodings than UTF-8, and brackets in numbers that would fill its queue of tokens (gigabytes for
/// 16 MB).
void check_characters(const std::string& text, const std::shared_ptr<const std::string>& source) {
  constexpr int max_open_brackets = 10'000;  // counted in quotes and comments too, hence far above max_depth
  Place place{source, 1, 0};
  int open_brackets = 0;
  bool indenting = true, tab = false;
  Place tab_place;
  for (const char c : text) {
    const auto byte = static_cast<unsigned char>(c);
    ++place.column;
    if (c == '\n') {
      place = {source, place.line + 1, 0};
      indenting = true;
      tab = false;
    } else if (c == '\t') {
      if (indenting && !tab) tab_place = place;
      tab = tab || indenting;
    } else if (c != ' ' && c != '\r') {
      if (indenting && tab) throw SceneError(tab_place.text(), "syntax: a tab in the indentation; allowed: spaces");
      indenting = false;
      if (byte < 0x20 || byte == 0x7f || byte > 0xf7) {
        throw SceneError(place.text(), fmt::format("syntax: the byte 0x{:02x}; allowed: text in UTF-8", byte));
      }
      if (c == '[' || c == '{') ++open_brackets;
      if (c == ']' || c == '}') --open_brackets;
      if (open_brackets > max_open_brackets) too_deep(place);
    }
  }
}

Value parse_with(const std::string& text, const std::shared_ptr<const std::string>& source) {
  if (text.size() > max_bytes) {
    throw SceneError(*source, fmt::format("is too large; allowed: {} MB", max_bytes >> 20));
  }
  constexpr std::string_view byte_order_mark = "\xef\xbb\xbf";
  const bool marked = text.compare(0, byte_order_mark.size(), byte_order_mark) == 0;
  const std::string yaml = marked ? text.substr(byte_order_mark.size()) : text;
  check_characters(yaml, source);
  TreeBuilder builder(yaml, source);
  try {
    std::istringstream stream(yaml);
    YAML::Parser parser(stream);
    while (parser.HandleNextDocument(builder)) {
    }
  } catch (const YAML::Exception& error) {
    const Place place =
        error.mark.is_null() ? Place{source, 1, 1} : Place{source, error.mark.line + 1, error.mark.column + 1};
    throw SceneError(place.text(), fmt::format("syntax: {}", shortened(error.msg)));
  }
  return builder.take_root();
}

}  // namespace

Value parse(const std::string& text, const std::string& source) {
  return parse_with(text, std::make_shared<const std::string>(source));
}

}  // namespace drench::yaml
