#pragma once
// Where the tests find the program and the scenes: where the build had them, or where the environment says
// (tools/pack); and where they write.

#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>

namespace drench::test {

/// The variable's value, or `otherwise` without one.
std::string from_environment(const char* name, const char* otherwise);

/// The program `drench`; DRENCH_PROGRAM replaces it.
std::string program();

/// The folder of scenes; DRENCH_SCENES replaces it.
std::string scenes_folder();

/// A temporary file of this process alone: tests run side by side.
inline std::filesystem::path own_file(const std::string& name) {
  return std::filesystem::temp_directory_path() / (std::to_string(::getpid()) + "_" + name);
}

/// What the file holds; nothing if there is none.
inline std::string read_text(const std::filesystem::path& path) {
  std::ifstream in(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>()};
}

}  // namespace drench::test
