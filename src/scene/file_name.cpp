#include "scene/file_name.hpp"

#include <fmt/format.h>

#include <filesystem>

#include "scene/motion.hpp"
#include "scene/scalars.hpp"

namespace drench {

namespace {

/// Beginnings that other programs resolve.
std::string hint_for(const std::string& name) {
  if (name.starts_with("~")) return "; '~' is not resolved here: write the path of the home folder";
  if (const auto end = name.find("://"); end != std::string::npos && end < 10)
    return fmt::format("; '{}' is not resolved here: write the path of the file", name.substr(0, end + 3));
  return "";
}

}  // namespace

FoundFile find_file(const yaml::Value& name, const std::string& folder, FileKind kind) {
  const bool mesh = kind != FileKind::any, cache = kind == FileKind::mesh_or_point_cache;
  namespace fs = std::filesystem;
  // a NUL byte would cut the name short in the system call
  if (name.kind != yaml::Value::Kind::scalar || name.text.empty() || name.text.find('\0') != std::string::npos)
    return {"", fmt::format("is {}; allowed: {}", name.shown(), mesh ? mesh_name_expected : "the name of a file")};
  std::string extension = fs::path(name.text).extension().string();
  for (char& c : extension) c = c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
  if (mesh && extension != ".obj" && extension != ".ply" && extension != ".stl" &&
      !(cache && !point_cache_ending(name.text).empty()))
    return {"", fmt::format("{} is not a mesh file that can be read; allowed: {}{}", name.shown(), mesh_file_allowed,
                            cache ? ", or a point cache .pc2, .mdd" : "")};
  std::error_code error;
  const fs::path file = fs::absolute(fs::path(folder) / name.text, error).lexically_normal();
  if (error || !fs::exists(file, error))
    return {"", fmt::format("there is no file '{}'{}", file.string(), hint_for(name.text))};
  if (!fs::is_regular_file(file, error)) return {"", fmt::format("'{}' is not a file", file.string())};
  return {file.string(), ""};
}

}  // namespace drench
