#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <string>
#include <utility>

#include "setup/mesh_files.hpp"

namespace drench {
namespace {

constexpr std::size_t stl_header = 84, stl_triangle = 50;  // bytes of a binary file: header with count, a triangle

std::uint32_t stl_count(const std::string& bytes) {
  std::uint32_t count = 0;
  for (std::size_t b = stl_header; b-- > 80;) count = 256 * count + static_cast<unsigned char>(bytes[b]);
  return count;
}

class StlText {
 public:
  StlText(const std::string& path, const std::string& bytes) : path_(path), bytes_(bytes) {
    file_.facets = true;
    if (bytes.starts_with("\xef\xbb\xbf")) at_ = 3;  // a byte order mark
  }

  PolygonFile read() {
    require(next(), "solid");
    for (bool open = true; open;) {
      skip_line();
      read_facets();
      skip_line();  // the name behind endsolid
      // A file may hold several solids.
      const std::string word = next();
      open = !word.empty();
      if (open) require(word, "solid");
    }
    file_.corner_texture.assign(file_.corner.size(), -1);
    return std::move(file_);
  }

 private:
  [[noreturn]] void fail(const std::string& why) const {
    unreadable_mesh(path_, fmt::format("line {}: {}", line_, why));
  }
  void require(const std::string& word, const char* wanted) const {
    if (word == wanted) return;
    if (word.empty()) fail(fmt::format("expected '{}', but the text ends: the file is incomplete", wanted));
    fail(fmt::format("expected '{}', found '{}'", wanted, word.substr(0, 40)));
  }
  /// In lower case; "" at the end.
  std::string next() {
    while (at_ < bytes_.size() && std::isspace(static_cast<unsigned char>(bytes_[at_]))) {
      if (bytes_[at_] == '\n') ++line_;
      ++at_;
    }
    std::string word;
    for (; at_ < bytes_.size() && !std::isspace(static_cast<unsigned char>(bytes_[at_])); ++at_)
      word += static_cast<char>(std::tolower(static_cast<unsigned char>(bytes_[at_])));
    return word;
  }
  void skip_line() {
    while (at_ < bytes_.size() && bytes_[at_] != '\n') ++at_;
  }
  void read_facets() {
    for (std::string word = next(); word != "endsolid"; word = next()) {
      if (word.empty())
        fail("the text ends before 'endsolid': the file is incomplete; if nothing is missing, add that line");
      if (word == "color") {
        skip_line();
        continue;
      }
      require(word, "facet");
      skip_line();  // the normal, which follows from the corners
      require(next(), "outer");
      require(next(), "loop");
      for (int corner = 0; corner < 3; ++corner) read_vertex();
      require(next(), "endloop");
      require(next(), "endfacet");
      file_.face_end.push_back(file_.corner.size());
      file_.face_line.push_back(static_cast<std::int32_t>(std::min<std::size_t>(line_, 2147483647)));
    }
  }
  void read_vertex() {
    require(next(), "vertex");
    Vec3 x;
    for (double& number : x) {
      const std::string word = next();
      char* end = nullptr;
      number = static_cast<double>(std::strtof(word.c_str(), &end));
      if (word.empty()) fail("the text ends within a vertex: the file is incomplete");
      if (*end != '\0' || !std::isfinite(number)) fail("a vertex needs three finite numbers");
    }
    file_.corner.push_back(static_cast<Index>(file_.points.size()));
    file_.points.push_back(x);
  }

  const std::string& path_;
  const std::string& bytes_;
  std::size_t at_ = 0, line_ = 1;
  PolygonFile file_;
};

}  // namespace

bool is_stl_text(const std::string& bytes) {
  // As kwsys::SystemTools::DetectFileType: less than a twentieth of the first bytes are none of a text.
  const std::size_t looked_at = std::min<std::size_t>(bytes.size(), 256);
  const auto others =
      std::count_if(bytes.begin(), bytes.begin() + static_cast<std::ptrdiff_t>(looked_at),
                    [](unsigned char c) { return !((c >= 0x20 && c <= 0x7f) || c == '\n' || c == '\r' || c == '\t'); });
  return looked_at > 0 && 20 * static_cast<std::size_t>(others) < looked_at;
}

bool is_binary_stl(const std::string& bytes, std::size_t size) {
  return bytes.size() > stl_header && !is_stl_text(bytes) &&
         stl_header + stl_triangle * std::size_t{stl_count(bytes)} == size;
}

PolygonFile read_stl_text(const std::string& path, const std::string& bytes) { return StlText(path, bytes).read(); }

std::string check_stl_file(const std::string& path, const std::string& bytes) {
  if (bytes.size() < stl_header) unreadable_mesh(path, "it is neither a text file nor long enough for a binary file");
  const std::size_t count = stl_count(bytes), fitting = (bytes.size() - stl_header) / stl_triangle;
  // Programs that do not know the count in advance leave 0 or −1: VTK goes by the length then.
  if (count == 0 || count == 0xffffffff) return "";
  if (count > fitting)
    unreadable_mesh(path, fmt::format("its header gives {} triangles, but its size allows {}: the file is incomplete",
                                      count, fitting));
  if (count == fitting) return "";
  return fmt::format("mesh file '{}': its header gives {} triangle{}, but its size allows {}; is the file complete?",
                     path, count, count == 1 ? "" : "s", fitting);
}

}  // namespace drench
