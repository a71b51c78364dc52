// Documenting: a Section that notes what is described.

#include <fmt/format.h>

#include "scene/scalars.hpp"
#include "scene/section_modes.hpp"

namespace drench {
namespace {

class DocumentSection : public Section {
 public:
  DocumentSection(Schema& schema, std::string path, bool deep) : schema_(schema), path_(std::move(path)), deep_(deep) {}

  void number(const char* key, double& value, const char* range, const char* unit, const char* meaning) override {
    note(key, "number", range, unit, yaml::text(value), meaning);
  }
  void number(const char* key, std::optional<double>&, const char* range, const char* unit,
              const char* meaning) override {
    note(key, "number", range, unit, "", meaning);
  }
  void number(const char* key, double& value, std::span<const Word<double>> words, const char* range, const char* unit,
              const char* meaning) override {
    std::string standard = yaml::text(value);
    for (const Word<double>& word : words)
      if (word.value == value) standard = word.word;
    note(key, "word or number", words_or(words, range), unit, standard, meaning);
  }
  void numbers(const char* key, std::span<double> values, const char* range, const char* unit,
               const char* meaning) override {
    note(key, fmt::format("{} numbers", values.size()), range, unit, yaml::text(std::span<const double>(values)),
         meaning);
  }
  void number(const char* key, Keyed<double>& value, const char* range, const char* unit,
              const char* meaning) override {
    note(key, "number or keyframes", range, unit, yaml::text(value.plain()), meaning);
  }
  void numbers(const char* key, Keyed<Vec3>& value, const char* range, const char* unit, const char* meaning) override {
    note(key, "3 numbers or keyframes", range, unit, yaml::text(std::span<const double>(value.plain())), meaning);
  }
  void integer(const char* key, int& value, const char* range, const char* unit, const char* meaning) override {
    note(key, "whole number", range, unit, std::to_string(value), meaning);
  }
  void integers(const char* key, std::span<int> values, const char* range, const char* unit,
                const char* meaning) override {
    note(key, fmt::format("{} whole numbers", values.size()), range, unit, fmt::format("[{}]", fmt::join(values, ", ")),
         meaning);
  }
  void integer_list(const char* key, std::vector<Index>&, const char* range, const char* unit,
                    const char* meaning) override {
    note(key, "list of whole numbers", range, unit, "", meaning);
  }
  void integer_pairs(const char* key, std::vector<std::array<Index, 2>>&, const char* range, const char* unit,
                     const char* meaning) override {
    note(key, "list of pairs of whole numbers", range, unit, "", meaning);
  }
  void boolean(const char* key, bool& value, const char* meaning) override {
    note(key, "switch", switch_allowed, "", value ? "true" : "false", meaning);
  }
  void on_off(const char* key, bool& value, const char* meaning) override { boolean(key, value, meaning); }
  void flag(const char* key, const char* meaning) override { note(key, "switch", "true", "", "", meaning); }
  void text(const char* key, std::string& value, const char* meaning) override {
    note(key, "text", text_allowed, "", value, meaning);
  }
  void texts(const char* key, std::span<std::string> values, const char* meaning) override {
    note(key, fmt::format("{} texts", values.size()), text_allowed, "", "", meaning);
  }
  void other_file(const char* key, std::string&, const char* meaning) override {
    note(key, "file", "", "", "", meaning);
  }
  void mesh_file(const char* key, std::string&, const char* meaning) override {
    note(key, "file", mesh_file_allowed, "", "", meaning);
  }

  void mesh_files(const char* key, std::vector<std::string>&, const char* meaning) override {
    note(key, "files", mesh_files_allowed, "", "", meaning);
  }
  void moving_mesh(const char* key, std::vector<std::string>&, const char* meaning) override {
    note(key, "files", moving_mesh_allowed, "", "", meaning);
  }
  void other_files(const char* key, std::vector<std::string>&, const char* meaning) override {
    note(key, "files", other_files_allowed, "", "", meaning);
  }

  void not_here(const char* key, const char*) override { schema_.elsewhere.emplace_back(key); }

 protected:
  std::size_t word_index(const char* key, const std::vector<const char*>& words, std::size_t index,
                         const char* meaning) override {
    note(key, "word", fmt::format("{}", fmt::join(words, ", ")), "", words[index], meaning);
    return index;
  }
  void map(const char* key, const char* meaning, const Describe& inside) override {
    note(key, "map", "", "", "", meaning);
    if (!deep_) return;
    DocumentSection sub(schema_, path_of(key), deep_);
    inside(sub);
  }
  void maps(const char* key, std::size_t, const char* meaning,
            const std::function<void(Section&, std::size_t)>& entry) override {
    note(key, "list of maps", "", "", "", meaning);
    if (!deep_) return;
    DocumentSection sub(schema_, path_of(key) + ".N", deep_);
    entry(sub, 0);
  }

 private:
  std::string path_of(const std::string& key) const { return path_.empty() ? key : path_ + "." + key; }
  void note(const char* key, const std::string& type, const std::string& allowed, const std::string& unit,
            const std::string& standard, const char* meaning) {
    using Need = SchemaKey::Need;
    const Said said = take_said();
    const Need need = said.required ? Need::required : said.one_of ? Need::one_of : Need::optional;
    schema_.keys.push_back({path_of(key), type, allowed, unit == "1" ? "" : unit, standard, meaning, need});
  }

  Schema& schema_;
  std::string path_;
  bool deep_;
};

}  // namespace

Schema document_section(const Describe& describe, bool deep) {
  Schema schema;
  DocumentSection section(schema, "", deep);
  describe(section);
  return schema;
}

}  // namespace drench
