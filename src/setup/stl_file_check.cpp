#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <string>
#include <system_error>
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

/// `size`: of the whole file, which begins with these bytes.
bool is_binary_stl(const std::string& bytes, std::size_t size) {
  return bytes.size() > stl_header && !is_stl_text(bytes) &&
         stl_header + stl_triangle * std::size_t{stl_count(bytes)} == size;
}

class StlText {
 public:
  StlText(const std::string& path, const std::string& bytes) : path_(path), bytes_(bytes) { file_.facets = true; }

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
      if (word.empty()) require(word, "vertex");
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

/// What the first bytes of files in other formats are, in lower case.
struct Beginning {
  const char* bytes;
  const char* what;
};
constexpr std::array beginnings{
    Beginning{"version https://git-lfs", "a Git LFS pointer, not the mesh: run git lfs pull"},
    Beginning{"<!doctype html", "a web page, not a mesh: download the file itself (raw)"},
    Beginning{"<html", "a web page, not a mesh: download the file itself (raw)"},
    Beginning{"<?xml", "XML, such as COLLADA (.dae): convert it to .obj"},
    Beginning{"<collada", "COLLADA (.dae): convert it to .obj"},
    Beginning{"gltf", "binary glTF: use drench import, with the extension .glb"},
    Beginning{"kaydara fbx", "FBX: use drench import, with the extension .fbx"},
    Beginning{"pxr-usdc", "USD: use drench import, with the extension .usdc"},
    Beginning{"#usda", "USD: use drench import, with the extension .usda"},
    Beginning{"blender-v", "a Blender file: use drench import, with the extension .blend"},
    Beginning{"pk\x03\x04", "a zip archive: unpack it"},
    Beginning{"\x1f\x8b", "a gzip archive: unpack it"},
};

/// The ending of the mesh format that the bytes have, as far as that is plain; else "".
std::string true_ending(const std::string& bytes, std::size_t size, const std::string& head) {
  if (head.starts_with("ply\n") || head.starts_with("ply\r")) return ".ply";
  if (is_binary_stl(bytes, size)) return ".stl";
  if (!is_stl_text(bytes)) return "";
  if (head.starts_with("solid") && bytes.find("facet") != std::string::npos) return ".stl";
  if (bytes.starts_with("v ") || bytes.find("\nv ") != std::string::npos) return ".obj";
  return "";
}

}  // namespace

bool is_stl_text(const std::string& bytes) {
  // As kwsys::SystemTools::DetectFileType: less than a twentieth of the first bytes are none of a text.
  const std::size_t looked_at = std::min<std::size_t>(bytes.size(), 256);
  const auto others =
      std::count_if(bytes.begin(), bytes.begin() + static_cast<std::ptrdiff_t>(looked_at),
                    [](unsigned char c) { return !((c >= 0x20 && c <= 0x7f) || c == '\n' || c == '\r' || c == '\t'); });
  return looked_at > 0 && 20 * static_cast<std::size_t>(others) < looked_at;
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
  return count == fitting
             ? ""
             : fmt::format(
                   "mesh file '{}': its header gives {} triangles, but its size allows {}: the others are not "
                   "read",
                   path, count, fitting);
}

void check_mesh_content(const std::string& path, const std::string& ending) {
  constexpr std::size_t enough = 4096;
  std::ifstream file(path, std::ios::binary);
  std::string bytes(enough, '\0');
  file.read(bytes.data(), static_cast<std::streamsize>(enough));
  bytes.resize(static_cast<std::size_t>(file.gcount()));
  std::error_code unknown;
  const auto size = static_cast<std::size_t>(std::filesystem::file_size(path, unknown));
  if (file.bad()) return;  // the reader reports it
  if (bytes.empty()) unreadable_mesh(path, "it is empty");
  const std::size_t begin = std::min(bytes.find_first_not_of(" \t\r\n"), bytes.size());
  std::string head = bytes.substr(begin, 64);
  if (head.starts_with("\xef\xbb\xbf")) head.erase(0, 3);
  std::transform(head.begin(), head.end(), head.begin(), [](unsigned char c) { return std::tolower(c); });
  for (const Beginning& other : beginnings)
    if (head.starts_with(other.bytes)) unreadable_mesh(path, fmt::format("it is {}", other.what));
  const std::string meant = true_ending(bytes, size, head);
  if (!meant.empty() && meant != ending)
    unreadable_mesh(path, fmt::format("its content is of the format {0}, not {1}: rename it to {0}", meant, ending));
}

}  // namespace drench
