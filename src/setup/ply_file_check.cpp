#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <map>
#include <sstream>
#include <vector>

#include "setup/mesh_file_check.hpp"

namespace drench {
namespace {

constexpr std::size_t longest_line = 4095;  // that VTK reads
constexpr std::int64_t most_corners = 255;

struct Type {
  int bytes;
  bool whole, with_sign;
};
const std::map<std::string, Type> types{
    {"char", {1, true, true}},    {"int8", {1, true, true}},     {"uchar", {1, true, false}},
    {"uint8", {1, true, false}},  {"short", {2, true, true}},    {"int16", {2, true, true}},
    {"ushort", {2, true, false}}, {"uint16", {2, true, false}},  {"int", {4, true, true}},
    {"int32", {4, true, true}},   {"uint", {4, true, false}},    {"uint32", {4, true, false}},
    {"float", {4, false, true}},  {"float32", {4, false, true}}, {"double", {8, false, true}},
    {"float64", {8, false, true}}};

struct Property {
  std::string name;
  Type type{};
  bool list = false;
  Type count{};  // of a list
};

struct Element {
  std::string name;
  std::int64_t count = 0;
  std::vector<Property> properties{};

  const Property* find(const std::string& property) const {
    const auto at =
        std::find_if(properties.begin(), properties.end(), [&](const Property& p) { return p.name == property; });
    return at == properties.end() ? nullptr : &*at;
  }
};

std::vector<std::string> words_of(const std::string& line) {
  std::istringstream in(line);
  std::vector<std::string> words;
  for (std::string word; in >> word;) words.push_back(word);
  return words;
}

class PlyFile {
 public:
  explicit PlyFile(const std::string& path)
      : path_(path),
        size_(static_cast<std::int64_t>(std::filesystem::file_size(path))),
        file_(path, std::ios::binary) {}

  void check() {
    read_header();
    check_geometry();
    for (const Element& element : elements_)
      for (std::int64_t k = 0; k < element.count; ++k)
        format_ == "ascii" ? check_line(element, k) : check_bytes(element, k);
  }

 private:
  [[noreturn]] void refuse(const std::string& why) const { unreadable_mesh(path_, why); }
  [[noreturn]] void refuse_line(const std::string& why) const { refuse(fmt::format("line {}: {}", line_number_, why)); }

  bool next_line() {
    ++line_number_;
    if (!std::getline(file_, line_)) return false;
    if (line_.size() > longest_line) refuse_line(fmt::format("it has more than {} bytes", longest_line));
    if (line_.find('\0') != std::string::npos) refuse_line("it holds a byte 0");
    return true;
  }

  void read_header() {
    if (!next_line() || words_of(line_) != std::vector<std::string>{"ply"}) refuse("it does not begin with 'ply'");
    while (next_line()) {
      const std::vector<std::string> words = words_of(line_);
      if (words.empty()) refuse_line("a line of the header is empty");
      if (words[0] == "end_header" && words.size() == 1) return;
      if (words[0] == "comment" || words[0] == "obj_info") continue;
      if (words[0] == "format" && words.size() == 3)
        read_format(words);
      else if (words[0] == "element" && words.size() == 3)
        read_element(words);
      else if (words[0] == "property" && !elements_.empty())
        read_property(words);
      else
        refuse_line("the header cannot hold '" + line_ + "'");
    }
    refuse("its header has no end");
  }
  void read_format(const std::vector<std::string>& words) {
    format_ = words[1];
    if (format_ != "ascii" && format_ != "binary_little_endian" && format_ != "binary_big_endian")
      refuse_line("the format is ascii, binary_little_endian or binary_big_endian");
  }
  void read_element(const std::vector<std::string>& words) {
    Element element{words[1]};
    char* end = nullptr;
    element.count = std::strtoll(words[2].c_str(), &end, 10);
    if (*end || element.count < 0 || element.count > size_)
      refuse_line(fmt::format("there cannot be {} of '{}' in {} bytes", words[2], words[1], size_));
    for (const Element& other : elements_)
      if (other.name == element.name) refuse_line("a second element '" + element.name + "'");
    elements_.push_back(element);
  }
  Type type_of(const std::string& name) const {
    const auto type = types.find(name);
    if (type == types.end()) refuse_line("there is no type '" + name + "'");
    return type->second;
  }
  void read_property(const std::vector<std::string>& words) {
    Property property;
    if (words.size() == 3) {
      property = {words[2], type_of(words[1])};
    } else if (words.size() == 5 && words[1] == "list") {
      property = {words[4], type_of(words[3]), true, type_of(words[2])};
      if (!property.count.whole) refuse_line("a list's length is a whole number");
    } else {
      refuse_line("a property is a type and a name, or 'list', two types and a name");
    }
    if (elements_.back().find(property.name)) refuse_line("a second property '" + property.name + "'");
    elements_.back().properties.push_back(property);
  }

  void check_geometry() {
    if (format_.empty()) refuse("its header has no format");
    for (const Element& element : elements_) {
      if (element.properties.empty()) refuse("element '" + element.name + "' has no property");
      if (element.name == "vertex" && element.find("x") && element.find("y") && element.find("z"))
        points_ = element.count;
      for (const Property& p : element.properties) check_kind(element, p);
      if (element.name != "face") continue;
      if (points_ < 0) refuse("element 'face' stands before 'vertex'");
      if (!element.find("vertex_indices") && !element.find("vertex_index"))
        refuse("element 'face' has no list 'vertex_indices'");
    }
    if (points_ < 0) refuse("it has no element 'vertex' with x, y and z");
  }
  static bool names_points(const Element& element, const Property& property) {
    return element.name == "face" && (property.name == "vertex_indices" || property.name == "vertex_index");
  }
  void check_kind(const Element& element, const Property& property) const {
    const bool corners = names_points(element, property);
    if (element.name == "vertex" && property.list) refuse("property '" + property.name + "' of 'vertex' is a list");
    if (element.name == "face" && property.list != (corners || property.name == "texcoord"))
      refuse(fmt::format("property '{}' of 'face' is {} list", property.name, property.list ? "a" : "no"));
    if (corners && !property.type.whole) refuse("the points of a face are whole numbers");
  }

  void check_count(const Element& element, std::int64_t k, std::int64_t count) const {
    if (count >= 0 && (element.name != "face" || count <= most_corners)) return;
    refuse(fmt::format("{} {}: a list of {}, allowed: 0 to {}", element.name, k, count, most_corners));
  }
  void check_corner(std::int64_t face, std::int64_t point) const {
    if (point < 0 || point >= points_)
      refuse(fmt::format("face {}: there is no point {}, allowed: 0 to {}", face, point, points_ - 1));
  }
  [[noreturn]] void ends(const Element& element, std::int64_t k) const {
    refuse(fmt::format("it ends in {} {} of {}", element.name, k, element.count));
  }

  void check_line(const Element& element, std::int64_t k) {
    if (!next_line()) ends(element, k);
    const std::vector<std::string> words = words_of(line_);
    std::size_t at = 0;
    const auto take = [&](bool whole) {
      if (at == words.size()) refuse_line(fmt::format("{} {} has too few numbers", element.name, k));
      char* end = nullptr;
      const std::string& word = words[at++];
      const double value = std::strtod(word.c_str(), &end);
      if (*end || (whole && value != static_cast<double>(static_cast<std::int64_t>(std::clamp(value, -1e15, 1e15)))))
        refuse_line(fmt::format("'{}' is no {}", word, whole ? "whole number" : "number"));
      return value;
    };
    for (const Property& p : element.properties) {
      std::int64_t numbers = 1;
      if (p.list) check_count(element, k, numbers = static_cast<std::int64_t>(std::clamp(take(true), -1.0, 1e9)));
      for (std::int64_t n = 0; n < numbers; ++n) {
        const double value = take(p.type.whole);
        if (names_points(element, p)) check_corner(k, static_cast<std::int64_t>(std::clamp(value, -1.0, 1e15)));
      }
    }
  }

  void check_bytes(const Element& element, std::int64_t k) {
    for (const Property& p : element.properties) {
      std::int64_t numbers = 1;
      if (p.list) check_count(element, k, numbers = read_whole(element, k, p.count));
      if (numbers * p.type.bytes > size_ - file_.tellg()) ends(element, k);
      if (!names_points(element, p)) {
        file_.seekg(numbers * p.type.bytes, std::ios::cur);
        continue;
      }
      for (std::int64_t n = 0; n < numbers; ++n) check_corner(k, read_whole(element, k, p.type));
    }
  }
  std::int64_t read_whole(const Element& element, std::int64_t k, Type type) {
    std::array<unsigned char, 4> bytes{};
    if (!file_.read(reinterpret_cast<char*>(bytes.data()), type.bytes)) ends(element, k);
    if (format_ == "binary_big_endian") std::reverse(bytes.begin(), bytes.begin() + type.bytes);
    std::uint32_t value = 0;
    for (int b = 0; b < type.bytes; ++b) value |= std::uint32_t(bytes[static_cast<std::size_t>(b)]) << (8 * b);
    const int unused = 32 - 8 * type.bytes;
    return type.with_sign ? static_cast<std::int32_t>(value << unused) >> unused : static_cast<std::int64_t>(value);
  }

  std::string path_, format_, line_;
  std::int64_t size_, line_number_ = 0, points_ = -1;
  std::ifstream file_;
  std::vector<Element> elements_;
};

}  // namespace

void check_ply_file(const std::string& path) { PlyFile(path).check(); }

}  // namespace drench
