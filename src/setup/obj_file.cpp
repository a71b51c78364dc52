#include "setup/obj_file.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <fstream>
#include <string_view>
#include <utility>

#include "setup/mesh_file_check.hpp"

namespace drench {
namespace {

class ObjReader {
 public:
  explicit ObjReader(const std::string& path) : path_(path), file_(path, std::ios::binary) {}

  ObjFile read() {
    while (next_line()) {
      const std::string_view kind = next_word();
      if (kind == "v")
        read_point();
      else if (kind == "vt")
        read_texture();
      else if (kind == "f")
        read_face();
    }
    return std::move(mesh_);
  }

 private:
  [[noreturn]] void refuse(const std::string& why) const {
    unreadable_mesh(path_, fmt::format("line {}: {}", line_number_, why));
  }

  bool next_line() {
    std::string rest;
    if (!std::getline(file_, line_)) return false;
    ++line_number_;
    while (goes_on() && std::getline(file_, rest)) {
      line_ += ' ' + rest;
      ++line_number_;
    }
    at_ = 0;
    return true;
  }
  /// Takes the backslash at the end away.
  bool goes_on() {
    if (line_.ends_with('\r')) line_.pop_back();
    if (!line_.ends_with('\\')) return false;
    line_.pop_back();
    return true;
  }

  /// "" at the end of the line and at a comment.
  std::string_view next_word() {
    constexpr const char* blanks = " \t\v\f\r";
    const std::size_t begin = std::min(line_.find_first_not_of(blanks, at_), line_.size());
    at_ = std::min(line_.find_first_of(blanks, begin), line_.size());
    const std::string_view word(line_.data() + begin, at_ - begin);
    if (!word.starts_with('#')) return word;
    at_ = line_.size();
    return {};
  }

  double next_number(const char* needs) {
    const std::string word(next_word());
    char* end = nullptr;
    const double value = std::strtod(word.c_str(), &end);
    if (word.empty() || end != word.c_str() + word.size() || !std::isfinite(value)) refuse(needs);
    return value;
  }
  void read_point() {
    Vec3 x;
    for (double& along : x) along = next_number("a point needs three finite numbers");
    mesh_.points.push_back(x);
  }
  void read_texture() {
    std::array<double, 2> uv{};
    for (double& along : uv) along = next_number("a texture coordinate needs two finite numbers");
    mesh_.texture.push_back(uv);
  }

  /// The index that begins at `text`, from 0; what stands behind it is left in `text`.
  Index next_index(const char*& text, std::size_t defined, const char* what, const std::string& corner) const {
    char* end = nullptr;
    const long long index = std::strtoll(text, &end, 10), count = static_cast<long long>(defined);
    if (end == text || index == 0 || index > count || index < -count)
      refuse(fmt::format("there is no {} {}, {} are defined so far", what, corner, count));
    text = end;
    return static_cast<Index>(index > 0 ? index - 1 : count + index);
  }
  void read_face() {
    const std::size_t begin = mesh_.corner.size();
    for (std::string corner(next_word()); !corner.empty(); corner = next_word()) {
      const char* text = corner.c_str();
      mesh_.corner.push_back(next_index(text, mesh_.points.size(), "point", corner));
      mesh_.cut |= *text == '/';
      const bool textured = text[0] == '/' && text[1] != '/' && text[1] != '\0';
      if (textured) ++text;
      mesh_.corner_texture.push_back(textured ? next_index(text, mesh_.texture.size(), "texture coordinate", corner)
                                              : -1);
      if (*text != '\0' && *text != '/') refuse("'" + corner + "' is no corner of a face");
    }
    if (mesh_.corner.size() < begin + 3) refuse("a face needs three corners");
    mesh_.face_end.push_back(mesh_.corner.size());
  }

  std::string path_, line_;
  std::ifstream file_;
  std::size_t at_ = 0;
  long line_number_ = 0;
  ObjFile mesh_;
};

}  // namespace

ObjFile read_obj_file(const std::string& path) { return ObjReader(path).read(); }

}  // namespace drench
