#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <bit>
#include <charconv>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <map>
#include <set>
#include <sstream>
#include <string_view>
#include <utility>

#include "setup/mesh_files.hpp"
#include "setup/particle_files.hpp"

namespace drench {
namespace {

enum class Type { int8, uint8, int16, uint16, int32, uint32, float32, float64 };
const std::map<std::string, Type, std::less<>> types{
    {"char", Type::int8},     {"int8", Type::int8},       {"uchar", Type::uint8},    {"uint8", Type::uint8},
    {"short", Type::int16},   {"int16", Type::int16},     {"ushort", Type::uint16},  {"uint16", Type::uint16},
    {"int", Type::int32},     {"int32", Type::int32},     {"uint", Type::uint32},    {"uint32", Type::uint32},
    {"float", Type::float32}, {"float32", Type::float32}, {"double", Type::float64}, {"float64", Type::float64}};

constexpr const char* blanks = " \t\r\n\v\f";

bool is_whole(Type type) { return type != Type::float32 && type != Type::float64; }

/// What stands for 1 in an attribute.
double largest(Type type) {
  switch (type) {
    case Type::int8:
      return 127;
    case Type::uint8:
      return 255;
    case Type::int16:
      return 32767;
    case Type::uint16:
      return 65535;
    case Type::int32:
      return 2147483647;
    case Type::uint32:
      return 4294967295;
    default:
      return 1;
  }
}

struct Property {
  std::string name;
  Type type = Type::float32, count = Type::uint8;  // count: of a list
  bool list = false;
};

struct Element {
  std::string name;
  std::int64_t count = 0;
  std::vector<Property> properties{};
};

std::vector<std::string> words_of(const std::string& line) {
  std::istringstream in(line);
  std::vector<std::string> words;
  for (std::string word; in >> word;) words.push_back(word);
  return words;
}

class PlyReader {
 public:
  PlyReader(const std::string& path, bool particles, const std::set<std::string>& attributes)
      : path_(path), bytes_(bytes_of_mesh(path)), particles_(particles), wanted_(attributes) {}

  PolygonFile read() {
    read_header();
    for (const Element& element : elements_) {
      if (element.name == "vertex")
        read_points(element);
      else if (element.name == "face")
        read_faces(element);
      else
        read_values(element, [](std::int64_t, std::size_t, const std::vector<double>&) {});
    }
    check_corners();
    return std::move(mesh_);
  }

 private:
  [[noreturn]] void refuse(const std::string& why) const { unreadable_mesh(path_, why); }
  [[noreturn]] void refuse_line(const std::string& why) const {
    const auto number = 1 + std::count(bytes_.begin(), bytes_.begin() + static_cast<std::ptrdiff_t>(token_), '\n');
    refuse(fmt::format("line {}: {}", number, why));
  }

  /// Without its end; false at the end of the file.
  bool next_line(std::string& line) {
    if (at_ >= bytes_.size()) return false;
    token_ = at_;
    const std::size_t end = std::min(bytes_.find('\n', at_), bytes_.size());
    line = bytes_.substr(at_, end - at_);
    at_ = end + 1;
    return true;
  }
  void read_header() {
    std::string line;
    if (!next_line(line) || words_of(line) != std::vector<std::string>{"ply"}) refuse("it does not begin with 'ply'");
    while (next_line(line)) {
      const std::vector<std::string> words = words_of(line);
      if (words.empty() || words[0] == "comment" || words[0] == "obj_info") continue;
      if (words[0] == "end_header") return check_header();
      if (words[0] == "format" && words.size() == 3)
        read_format(words[1]);
      else if (words[0] == "element" && words.size() == 3)
        read_element(words[1], words[2]);
      else if (words[0] == "property" && !elements_.empty())
        read_property(words);
      else
        refuse_line("the header cannot hold '" + words[0] + "' here");
    }
    refuse("its header has no end");
  }
  void read_format(const std::string& format) {
    ascii_ = format == "ascii";
    swapped_ = format == (std::endian::native == std::endian::little ? "binary_big_endian" : "binary_little_endian");
    if (!ascii_ && format != "binary_little_endian" && format != "binary_big_endian")
      refuse_line("the format is ascii, binary_little_endian or binary_big_endian");
    has_format_ = true;
  }
  void read_element(const std::string& name, const std::string& count) {
    Element element{name};
    const auto [end, error] = std::from_chars(count.data(), count.data() + count.size(), element.count);
    const auto size = static_cast<std::int64_t>(bytes_.size());
    if (error != std::errc() || *end != '\0' || element.count < 0 || element.count > size)
      refuse_line(fmt::format("there cannot be {} of '{}' in {} bytes", count, name, size));
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
      property = {words[4], type_of(words[3]), type_of(words[2]), true};
      if (!is_whole(property.count)) refuse_line("a list's length is a whole number");
    } else {
      refuse_line("a property is a type and a name, or 'list', two types and a name");
    }
    elements_.back().properties.push_back(property);
  }
  void check_header() const {
    if (!has_format_) refuse("its header has no format");
    for (const char* name : {"vertex", "face"})
      if (std::count_if(elements_.begin(), elements_.end(), [&](const Element& e) { return e.name == name; }) > 1)
        refuse(fmt::format("it has two elements '{}'", name));
  }

  [[noreturn]] void ends(const Element& element, std::int64_t k) const {
    refuse(fmt::format("it ends in {} {} of {}", element.name, k, element.count));
  }
  /// In a text an element is a line.
  void begin_line(const Element& element, std::int64_t k) {
    token_ = bytes_.find_first_not_of(blanks, at_);
    if (token_ == std::string::npos) ends(element, k);
    at_ = token_;
    line_end_ = std::min(bytes_.find('\n', at_), bytes_.size());
  }
  double next_word(const Element& element, std::int64_t k, Type type) {
    const std::size_t next = bytes_.find_first_not_of(blanks, at_);
    if (next >= line_end_) refuse_line(fmt::format("{} {} has too few numbers", element.name, k));
    token_ = next;
    at_ = std::min(bytes_.find_first_of(blanks, token_), bytes_.size());
    const char *begin = bytes_.data() + token_, *end = bytes_.data() + at_;
    std::int64_t whole = 0;
    const auto read = std::from_chars(begin + (*begin == '+'), end, whole);
    if (read.ec == std::errc() && read.ptr == end) return static_cast<double>(whole);
    char* stopped = nullptr;
    const std::string word(begin, end);
    const double value = std::strtod(word.c_str(), &stopped);
    if (is_whole(type) || *stopped != '\0')
      refuse_line(
          fmt::format("'{}' of {} {} is no {}", word, element.name, k, is_whole(type) ? "whole number" : "number"));
    return value;
  }
  template <class T>
  double next_bytes(const Element& element, std::int64_t k) {
    std::array<char, sizeof(T)> raw;
    if (bytes_.size() < sizeof(T) || at_ > bytes_.size() - sizeof(T)) ends(element, k);
    std::memcpy(raw.data(), bytes_.data() + at_, sizeof(T));
    if (swapped_) std::reverse(raw.begin(), raw.end());
    at_ += sizeof(T);
    return static_cast<double>(std::bit_cast<T>(raw));
  }
  double next_value(const Element& element, std::int64_t k, Type type) {
    if (ascii_) return next_word(element, k, type);
    switch (type) {
      case Type::int8:
        return next_bytes<std::int8_t>(element, k);
      case Type::uint8:
        return next_bytes<std::uint8_t>(element, k);
      case Type::int16:
        return next_bytes<std::int16_t>(element, k);
      case Type::uint16:
        return next_bytes<std::uint16_t>(element, k);
      case Type::int32:
        return next_bytes<std::int32_t>(element, k);
      case Type::uint32:
        return next_bytes<std::uint32_t>(element, k);
      case Type::float32:
        return next_bytes<float>(element, k);
      default:
        return next_bytes<double>(element, k);
    }
  }
  /// Calls `take(k, property, values)` for each property of each element: one value, or those of a list.
  template <class Take>
  void read_values(const Element& element, const Take& take) {
    std::vector<double> values;
    if (element.properties.empty()) return;
    for (std::int64_t k = 0; k < element.count; ++k) {
      if (ascii_) begin_line(element, k);
      for (std::size_t p = 0; p < element.properties.size(); ++p) {
        const Property& property = element.properties[p];
        const double count = property.list ? next_value(element, k, property.count) : 1;
        if (count < 0) refuse(fmt::format("{} {}: a list of {} numbers", element.name, k, count));
        values.clear();
        for (double n = 0; n < count; ++n) values.push_back(next_value(element, k, property.type));
        take(k, p, values);
      }
      if (ascii_) at_ = line_end_;
    }
  }

  static std::size_t place(const Element& element, std::initializer_list<std::string_view> names) {
    std::size_t p = 0;
    while (p < element.properties.size() &&
           std::find(names.begin(), names.end(), element.properties[p].name) == names.end())
      ++p;
    return p;
  }
  void read_points(const Element& element) {
    const std::array<std::size_t, 3> at{place(element, {"x"}), place(element, {"y"}), place(element, {"z"})};
    const std::array<std::size_t, 2> uv{place(element, {"u", "s", "texture_u"}),
                                        place(element, {"v", "t", "texture_v"})};
    const std::array<std::size_t, 3> v{place(element, {"vx"}), place(element, {"vy"}), place(element, {"vz"})};
    const std::size_t mass = place(element, {"mass"}), id = place(element, {"id"});
    const auto there = [&](std::size_t p) { return p < element.properties.size() && !element.properties[p].list; };
    if (!std::all_of(at.begin(), at.end(), there)) refuse("its element 'vertex' has no numbers x, y and z");
    mesh_.points.resize(static_cast<std::size_t>(element.count));
    if (particles_ && std::all_of(v.begin(), v.end(), there)) mesh_.velocity.resize(mesh_.points.size());
    if (particles_ && there(mass)) mesh_.mass.resize(mesh_.points.size());
    if (particles_ && there(id)) mesh_.id.resize(mesh_.points.size());
    if (std::all_of(uv.begin(), uv.end(), there)) mesh_.texture.resize(mesh_.points.size());
    std::map<std::size_t, std::vector<double>*> attribute;  // by property
    for (std::size_t p = 0; p < element.properties.size(); ++p)
      if (there(p) && wanted_.count(element.properties[p].name) > 0)
        (attribute[p] = &mesh_.attributes[element.properties[p].name])->resize(mesh_.points.size());
    read_values(element, [&](std::int64_t k, std::size_t p, const std::vector<double>& values) {
      if (const auto found = attribute.find(p); found != attribute.end())
        (*found->second)[static_cast<std::size_t>(k)] = values[0] / largest(element.properties[p].type);
      for (std::size_t a = 0; a < 3; ++a)
        if (p == at[a]) mesh_.points[static_cast<std::size_t>(k)][a] = values[0];
      for (std::size_t a = 0; a < 3 && !mesh_.velocity.empty(); ++a)
        if (p == v[a]) mesh_.velocity[static_cast<std::size_t>(k)][a] = values[0];
      if (p == mass && !mesh_.mass.empty()) mesh_.mass[static_cast<std::size_t>(k)] = values[0];
      if (p == id && !mesh_.id.empty()) mesh_.id[static_cast<std::size_t>(k)] = id_of(values[0]);
      for (std::size_t a = 0; a < 2 && !mesh_.texture.empty(); ++a)
        if (p == uv[a]) mesh_.texture[static_cast<std::size_t>(k)][a] = values[0];
    });
    point_texture_ = !mesh_.texture.empty();
  }
  void read_faces(const Element& element) {
    const std::size_t corners = place(element, {"vertex_indices", "vertex_index"}), uv = place(element, {"texcoord"});
    if (corners == element.properties.size() || !element.properties[corners].list ||
        !is_whole(element.properties[corners].type))
      refuse("its element 'face' has no list 'vertex_indices' of whole numbers");
    std::vector<double> own;  // u, v of the corners of one face
    std::size_t begin = 0;
    read_values(element, [&](std::int64_t, std::size_t p, const std::vector<double>& values) {
      if (p == uv) own = values;
      if (p == corners)
        for (const double point : values)
          mesh_.corner.push_back(static_cast<Index>(std::clamp(point, -1.0, 2147483647.0)));
      if (p + 1 < element.properties.size()) return;
      mesh_.face_end.push_back(mesh_.corner.size());
      add_texture(begin, own);
      begin = mesh_.corner.size();
      own.clear();
    });
  }
  /// That of the face itself if it has one for each corner, else its points'.
  void add_texture(std::size_t begin, const std::vector<double>& own) {
    const std::size_t count = mesh_.corner.size() - begin;
    const bool has_own = count > 0 && own.size() == 2 * count;
    for (std::size_t c = 0; c < count; ++c) {
      mesh_.corner_texture.push_back(has_own ? static_cast<Index>(mesh_.texture.size())
                                             : (point_texture_ ? mesh_.corner[begin + c] : -1));
      if (has_own) mesh_.texture.push_back({own[2 * c], own[2 * c + 1]});
    }
  }
  void check_corners() const {
    if (std::none_of(elements_.begin(), elements_.end(), [](const Element& e) { return e.name == "vertex"; }))
      refuse("it has no element 'vertex'");
    std::size_t corner = 0;
    for (std::size_t f = 0; f < mesh_.face_end.size(); ++f)
      for (; corner < mesh_.face_end[f]; ++corner)
        if (const Index p = mesh_.corner[corner]; p < 0 || static_cast<std::size_t>(p) >= mesh_.points.size())
          refuse(fmt::format("face {}: there is no point {}, allowed: 0 to {}", f, p,
                             static_cast<std::int64_t>(mesh_.points.size()) - 1));
  }

  std::string path_, bytes_;
  std::size_t at_ = 0, token_ = 0, line_end_ = 0;  // of the next byte, of the last word or line, and of this line's end
  bool ascii_ = false, swapped_ = false, has_format_ = false, point_texture_ = false, particles_ = false;
  std::set<std::string> wanted_;
  std::vector<Element> elements_;
  PolygonFile mesh_;
};

}  // namespace

PolygonFile read_ply_file(const std::string& path, bool particles, const std::set<std::string>& attributes) {
  return PlyReader(path, particles, attributes).read();
}

}  // namespace drench
