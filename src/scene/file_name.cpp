#include "scene/file_name.hpp"

#include <fmt/format.h>

#include <filesystem>

#include "scene/scalars.hpp"

namespace drench {

FoundFile find_file(const yaml::Value& name, const std::string& folder, bool mesh) {
  namespace fs = std::filesystem;
  // a NUL byte would cut the name short in the system call
  if (name.kind != yaml::Value::Kind::scalar || name.text.empty() || name.text.find('\0') != std::string::npos)
    return {"", fmt::format("is {}; allowed: {}", name.shown(), mesh ? mesh_name_expected : "the name of a file")};
  std::string extension = fs::path(name.text).extension().string();
  for (char& c : extension) c = c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
  if (mesh && extension != ".obj" && extension != ".ply" && extension != ".stl")
    return {"", fmt::format("{} is not a mesh file that can be read; allowed: {}", name.shown(), mesh_file_allowed)};
  std::error_code error;
  const fs::path file = fs::absolute(fs::path(folder) / name.text, error).lexically_normal();
  if (error || !fs::exists(file, error)) return {"", fmt::format("there is no file '{}'", file.string())};
  if (!fs::is_regular_file(file, error)) return {"", fmt::format("'{}' is not a file", file.string())};
  return {file.string(), ""};
}

}  // namespace drench
