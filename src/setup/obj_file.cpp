#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <limits>
#include <sstream>
#include <string_view>
#include <utility>

#include "setup/mesh_files.hpp"

namespace drench {
namespace {

/// Old Macintosh programs end lines by a carriage return alone.
std::string with_line_feeds(std::string text) {
  if (text.find('\n') == std::string::npos) std::replace(text.begin(), text.end(), '\r', '\n');
  return text;
}

class ObjReader {
 public:
  ObjReader(const std::string& path, bool names)
      : path_(path), file_(with_line_feeds(bytes_of_mesh(path))), with_names_(names) {
    constexpr std::array<int, 3> byte_order_mark{0xef, 0xbb, 0xbf};
    for (const int byte : byte_order_mark)
      if (file_.peek() == byte) file_.get();
  }

  PolygonFile read() {
    while (next_line()) {
      const std::string_view kind = next_word();
      if (kind == "v")
        read_point();
      else if (kind == "vt")
        read_texture();
      else if (kind == "f")
        read_face();
      else if (kind == "g")
        group_ = rest_of_line();
      else if (kind == "o")
        object_ = rest_of_line();
      else if (kind == "usemtl")
        material_ = rest_of_line();
    }
    return std::move(mesh_);
  }

 private:
  [[noreturn]] void refuse(const std::string& why) const {
    unreadable_mesh(path_, fmt::format("line {}: {}", line_number_, why));
  }

  bool next_line() {
    line_.clear();
    at_ = 0;
    do {
      std::string part;
      if (!std::getline(file_, part)) return !line_.empty();
      ++line_number_;
      if (part.ends_with('\r')) part.pop_back();
      line_ += part;
    } while (goes_on());
    return true;
  }
  /// Takes the backslash at the end away; a comment does not go on.
  bool goes_on() {
    if (!line_.ends_with('\\') || line_.find('#') != std::string::npos) return false;
    line_.back() = ' ';
    return true;
  }

  /// "" at the end of the line and at a comment.
  std::string_view next_word() {
    constexpr const char* blanks = " \t\v\f";
    const std::size_t begin = std::min(line_.find_first_not_of(blanks, at_), line_.size());
    at_ = std::min(line_.find_first_of(blanks, begin), line_.size());
    const std::string_view word(line_.data() + begin, at_ - begin);
    if (!word.starts_with('#')) return word;
    at_ = line_.size();
    return {};
  }
  std::vector<std::string> rest_of_line() {
    std::vector<std::string> words;
    for (std::string_view word = next_word(); !word.empty(); word = next_word()) words.emplace_back(word);
    return words;
  }

  /// NaN: the next word is no number, or there is none.
  double next_number() {
    const std::string word(next_word());
    char* end = nullptr;
    const double value = std::strtod(word.c_str(), &end);
    return word.empty() || *end != '\0' ? std::numeric_limits<double>::quiet_NaN() : value;
  }
  void read_point() {
    Vec3 x;
    for (double& along : x) {
      along = next_number();
      if (!std::isfinite(along)) refuse("a point needs three finite numbers");
    }
    mesh_.points.push_back(x);
  }
  void read_texture() {
    const std::vector<std::string> words = rest_of_line();
    std::array<double, 2> uv{};  // v may be left out
    for (std::size_t a = 0; a < std::min<std::size_t>(2, words.size()); ++a)
      uv[a] = std::strtod(words[a].c_str(), nullptr);
    mesh_.texture.push_back(uv);
  }

  /// The index that begins at `text`, from 0; what stands behind it is left in `text`.
  Index next_index(const char*& text, std::size_t defined, const char* what, const std::string& corner) const {
    char* end = nullptr;
    const long long index = std::strtoll(text, &end, 10), count = static_cast<long long>(defined);
    if (end == text || index == 0 || index > count || index < -count)
      refuse(fmt::format("there is no {} {}, {} are defined so far", what,
                         end == text ? corner : std::string(text, static_cast<const char*>(end)), count));
    text = end;
    return static_cast<Index>(index > 0 ? index - 1 : count + index);
  }
  /// A corner is 1, 1/1, 1//1 or 1/1/1: point, texture coordinate, normal, of which the last does not count.
  void read_corner(const std::string& corner) {
    const char* text = corner.c_str();
    mesh_.corner.push_back(next_index(text, mesh_.points.size(), "point", corner));
    const bool textured = text[0] == '/' && text[1] != '/' && text[1] != '\0';
    if (textured) ++text;
    // A file without any texture coordinate may still number them.
    const bool has_texture = textured && !mesh_.texture.empty();
    mesh_.corner_texture.push_back(has_texture ? next_index(text, mesh_.texture.size(), "texture coordinate", corner)
                                               : -1);
    if (textured && !has_texture) text += std::strspn(text, "-0123456789");
    while (*text == '/') ++text;
    char* end = nullptr;
    if (*text != '\0' && (std::strtoll(text, &end, 10) == 0 || *end != '\0'))
      refuse("'" + corner + "' is not a corner of a face");
  }
  void read_face() {
    const std::size_t begin = mesh_.corner.size();
    for (std::string corner(next_word()); !corner.empty(); corner = next_word()) read_corner(corner);
    if (mesh_.corner.size() < begin + 3) refuse("a face needs three corners");
    mesh_.face_end.push_back(mesh_.corner.size());
    mesh_.face_line.push_back(static_cast<std::int32_t>(std::min(line_number_, 2147483647L)));
    if (!with_names_) return;
    mesh_.names.push_back(group_);
    for (const auto* more : {&object_, &material_})
      mesh_.names.back().insert(mesh_.names.back().end(), more->begin(), more->end());
  }

  std::string path_, line_;
  std::istringstream file_;
  bool with_names_;
  std::size_t at_ = 0;
  long line_number_ = 0;
  std::vector<std::string> group_, object_, material_;
  PolygonFile mesh_;
};

}  // namespace

PolygonFile read_obj_file(const std::string& path, bool names) { return ObjReader(path, names).read(); }

}  // namespace drench
