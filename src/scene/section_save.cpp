// Saving: a Section that writes keys and values in the scene file's syntax, each with its unit as a comment.

#include <fmt/format.h>

#include "scene/scalars.hpp"
#include "scene/section_modes.hpp"

namespace drench {
namespace {

std::string in_quotes(const std::string& words) { return "\"" + yaml::escaped(words, "\"\\") + "\""; }

std::string comment_of(const std::string& unit) { return unit == "1" || unit.starts_with('(') ? "" : unit; }

std::string text_of(double value) { return yaml::text(value); }
std::string text_of(const Vec3& value) { return yaml::text(std::span<const double>(value)); }

/// A plain value, or [[time, value], …]; with the interpolation unless it is linear.
template <class T>
std::string text_of(const Keyed<T>& value) {
  if (!value.has_keys()) return text_of(value.plain());
  std::string keys;
  for (const Key<T>& key : value.keys())
    keys += fmt::format("{}[{}, {}]", keys.empty() ? "" : ", ", yaml::text(key.time), text_of(key.value));
  for (const auto& [word, between] : interpolation_words)
    if (between == value.interpolation() && between != Interpolation::linear)
      return fmt::format("{{keys: [{}], interpolation: {}}}", keys, word);
  return "[" + keys + "]";
}

class SaveSection : public Section {
 public:
  explicit SaveSection(bool on_one_line) : one_line_(on_one_line) {}

  void number(const char* key, double& value, const char*, const char* unit, const char*) override {
    write(key, yaml::text(value), comment_of(unit));
  }
  void number(const char* key, std::optional<double>& value, const char*, const char* unit, const char*) override {
    saved_if(value.has_value());
    write(key, yaml::text(value.value_or(0)), comment_of(unit));
  }
  void number(const char* key, double& value, std::span<const Word<double>> words, const char*, const char* unit,
              const char*) override {
    for (const Word<double>& word : words)
      if (word.value == value) return write(key, word.word);
    write(key, yaml::text(value), comment_of(unit));
  }
  void numbers(const char* key, std::span<double> values, const char*, const char* unit, const char*) override {
    write(key, yaml::text(std::span<const double>(values)), comment_of(unit));
  }
  void number(const char* key, Keyed<double>& value, const char*, const char* unit, const char*) override {
    write(key, text_of(value), comment_of(unit));
  }
  void numbers(const char* key, Keyed<Vec3>& value, const char*, const char* unit, const char*) override {
    write(key, text_of(value), comment_of(unit));
  }
  void integer(const char* key, int& value, const char*, const char* unit, const char*) override {
    write(key, std::to_string(value), comment_of(unit));
  }
  void integers(const char* key, std::span<int> values, const char*, const char* unit, const char*) override {
    write(key, fmt::format("[{}]", fmt::join(values, ", ")), comment_of(unit));
  }
  void integer_list(const char* key, std::vector<Index>& values, const char*, const char* unit, const char*) override {
    write(key, fmt::format("[{}]", fmt::join(values, ", ")), comment_of(unit));
  }
  void integer_pairs(const char* key, std::vector<std::array<Index, 2>>& values, const char*, const char* unit,
                     const char*) override {
    std::string all;
    for (const auto& [a, b] : values) all += fmt::format("{}[{}, {}]", all.empty() ? "" : ", ", a, b);
    write(key, "[" + all + "]", comment_of(unit));
  }
  void boolean(const char* key, bool& value, const char*) override { write(key, value ? "true" : "false"); }
  void on_off(const char* key, bool& value, const char*) override { write(key, value ? "on" : "off"); }
  void flag(const char* key, const char*) override { write(key, "true"); }
  void text(const char* key, std::string& value, const char*) override { write(key, in_quotes(value)); }
  void texts(const char* key, std::span<std::string> values, const char*) override {
    std::string all;
    for (const std::string& value : values) all += (all.empty() ? "" : ", ") + in_quotes(value);
    write(key, "[" + all + "]");
  }
  void other_file(const char* key, std::string& value, const char*) override { write(key, in_quotes(value)); }
  void mesh_file(const char* key, std::string& value, const char*) override { write(key, in_quotes(value)); }

  void mesh_files(const char* key, std::vector<std::string>& values, const char*) override {
    std::string all;
    for (const std::string& value : values) all += (all.empty() ? "" : ", ") + in_quotes(value);
    write(key, "[" + all + "]");
  }
  void moving_mesh(const char* key, std::vector<std::string>& values, const char* meaning) override {
    mesh_files(key, values, meaning);
  }
  void other_files(const char* key, std::vector<std::string>& values, const char* meaning) override {
    mesh_files(key, values, meaning);
  }

  void one_line() override { one_line_ = true; }
  void remark(const char* text) override {
    if (last_saved_) lines_.back().comment = text;
  }

  /// All of it, on one line or as lines.
  std::string inner() const {
    std::string all;
    for (const Line& line : lines_) {
      if (one_line_) {
        all += (all.empty() ? "" : ", ") + line.text;
      } else {
        all += line.text + (line.comment.empty() ? "" : "  # " + line.comment) + "\n";
      }
    }
    return one_line_ ? "{" + all + "}" : all;
  }

 protected:
  std::size_t word_index(const char* key, const std::vector<const char*>& words, std::size_t index,
                         const char*) override {
    write(key, words[index]);
    return index;
  }
  void map(const char* key, const char*, const Describe& inside) override {
    SaveSection sub(one_line_);
    inside(sub);
    if (sub.one_line_) return write(key, sub.inner());
    if (begin(key)) append(sub, "  ", "  ");
  }
  void maps(const char* key, std::size_t count, const char*,
            const std::function<void(Section&, std::size_t)>& entry) override {
    std::vector<SaveSection> items(count, SaveSection(one_line_));
    for (std::size_t i = 0; i < count; ++i) entry(items[i], i);
    saved_if(count > 0);
    if (one_line_) {
      std::string all;
      for (const SaveSection& sub : items) all += (all.empty() ? "" : ", ") + sub.inner();
      return write(key, "[" + all + "]");
    }
    if (!begin(key)) return;
    for (const SaveSection& sub : items) {
      if (sub.one_line_)
        lines_.push_back({"  - " + sub.inner(), ""});
      else
        append(sub, "  - ", "    ");
    }
  }

 private:
  struct Line {
    std::string text, comment;
  };

  void write(const char* key, const std::string& value, const std::string& comment = "") {
    last_saved_ = take_said().saved;
    if (last_saved_) lines_.push_back({fmt::format("{}: {}", key, value), comment});
  }
  /// A key whose value stands on the lines below it.
  bool begin(const char* key) {
    last_saved_ = take_said().saved;
    if (last_saved_) lines_.push_back({fmt::format("{}:", key), ""});
    return last_saved_;
  }
  void append(const SaveSection& sub, const char* first_indent, const char* indent) {
    for (std::size_t i = 0; i < sub.lines_.size(); ++i)
      lines_.push_back({(i == 0 ? first_indent : indent) + sub.lines_[i].text, sub.lines_[i].comment});
  }

  std::vector<Line> lines_;
  bool one_line_ = false, last_saved_ = false;
};

}  // namespace

std::string save_section(const Describe& describe) {
  SaveSection section(false);
  describe(section);
  return section.inner();
}

}  // namespace drench
