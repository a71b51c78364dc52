// Files that are no meshes, or meshes of another format than their names say: the reason in one line.

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <filesystem>
#include <fstream>
#include <string>
#include <system_error>

#include "setup/mesh_files.hpp"

namespace drench {
namespace {

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
    Beginning{"\xff\xfe", "text in UTF-16: save it as UTF-8"},
    Beginning{"\xfe\xff", "text in UTF-16: save it as UTF-8"},
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

void check_mesh_content(const std::string& path, const std::string& ending) {
  constexpr std::size_t enough = 4096;
  std::ifstream file(path, std::ios::binary);
  std::string bytes(enough, '\0');
  file.read(bytes.data(), static_cast<std::streamsize>(enough));
  bytes.resize(static_cast<std::size_t>(file.gcount()));
  std::error_code unknown;
  const auto size = static_cast<std::size_t>(std::filesystem::file_size(path, unknown));
  if (!file.is_open() || file.bad()) return;  // the reader reports it
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
