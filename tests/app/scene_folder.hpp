#pragma once
// Scenes that are read in a folder of their own, for the tests of the loader.

#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include "scene/load.hpp"

namespace drench::testing {

namespace fs = std::filesystem;

/// A folder of its own with exists.obj, cache.pc2, cache.mdd, mesh.PLY, seams.txt and folder.obj/, removed at the end.
class SceneFolder {
 public:
  SceneFolder() {
    path_ = fs::temp_directory_path() / ("drench_scene_loader_" + std::to_string(::getpid()));
    fs::create_directories(path_ / "folder.obj");
    std::ofstream(path_ / "exists.obj") << "v 0 0 0\n";
    for (const char* cache : {"cache.pc2", "cache.mdd"}) std::ofstream(path_ / cache) << "no cache\n";
    std::ofstream(path_ / "mesh.PLY") << "ply\n";
    std::ofstream(path_ / "seams.txt") << "0 3\n";
  }
  ~SceneFolder() {
    std::error_code error;
    fs::remove_all(path_, error);
  }
  std::string file(const std::string& name) const { return (path_ / name).string(); }

 private:
  fs::path path_;
};

/// One for all tests of a program.
inline const SceneFolder& folder() {
  static const SceneFolder the_folder;
  return the_folder;
}

/// The scene of a text, as if it stood in that folder.
inline Scene parse(const std::string& yaml, const std::vector<std::string>& overrides = {}) {
  return parse_scene(yaml, folder().file("test.yaml"), overrides);
}

/// What the error says, "" when the scene loads. The folder's name is cut off.
inline std::string error_of(const std::string& yaml, const std::vector<std::string>& overrides = {}) {
  try {
    parse(yaml, overrides);
  } catch (const SceneError& error) {
    const std::string what = error.what(), prefix = folder().file("");
    return what.compare(0, prefix.size(), prefix) == 0 ? what.substr(prefix.size()) : what;
  }
  return "";
}

/// What loading a file comes to, "" if it loads.
inline std::string load_error(const std::string& path) {
  try {
    load_scene(path);
  } catch (const SceneError& error) {
    return error.what();
  }
  return "";
}

}  // namespace drench::testing
