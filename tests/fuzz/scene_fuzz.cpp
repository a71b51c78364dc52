// The scene loader under libFuzzer: whatever the bytes, a scene that reads the same again when it is written out, or
// one line that begins with the file. tools/dev/fuzz builds and runs it.

#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <string>

#include "app/good_scenes.hpp"
#include "app/scene_equal.hpp"
#include "scene/load.hpp"

namespace {

constexpr const char* scene_file = "/nowhere/fuzz.yaml";

[[noreturn]] void wrong(const char* what, const std::string& detail) {
  std::fprintf(stderr, "%s: %s\n", what, detail.c_str());
  std::abort();
}

}  // namespace

/// Puts the tests' own scenes into the first folder of the command line, beside what the fuzzer found before.
extern "C" int LLVMFuzzerInitialize(int* argc, char*** argv) {
  using namespace drench::testing;
  for (int i = 1; i < *argc; ++i) {
    const std::filesystem::path folder = (*argv)[i];
    if (!std::filesystem::is_directory(folder)) continue;
    std::ofstream(folder / "minimal") << minimal;
    std::ofstream(folder / "fluid_and_cloth") << fluid_and_cloth;
    std::ofstream(folder / "everything") << everything;
    break;
  }
  return 0;
}

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string text(reinterpret_cast<const char*>(data), size);
  drench::Scene scene;
  try {
    scene = drench::parse_scene(text, scene_file);
  } catch (const drench::SceneError& error) {
    const std::string line = error.what();
    if (!line.starts_with(std::string(scene_file) + ":") || line.find('\n') != line.npos) wrong("not located", line);
    return 0;
  }
  const std::string written = to_yaml(scene);
  try {
    if (!drench::same_scene(drench::parse_scene(written, scene_file), scene)) wrong("reads as another scene", written);
  } catch (const drench::SceneError& error) {
    wrong(error.what(), written);
  }
  return 0;
}
