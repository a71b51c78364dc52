#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <filesystem>
#include <sstream>

#include "app/commands.hpp"
#include "app/import_formats.hpp"
#include "app/python.hpp"

namespace drench {
namespace {

constexpr std::array usd_endings{".usd", ".usda", ".usdc", ".usdz"};
constexpr std::array blender_endings{".fbx", ".gltf", ".glb", ".abc", ".blend"};
constexpr std::array scene_endings{".xml", ".json"};

std::string ending_of(const std::string& file) {
  std::string ending = std::filesystem::path(file).extension().string();
  std::transform(ending.begin(), ending.end(), ending.begin(), [](unsigned char c) { return std::tolower(c); });
  return ending;
}

template <class Endings>
bool has_ending(const std::string& file, const Endings& endings) {
  return std::find(endings.begin(), endings.end(), ending_of(file)) != endings.end();
}

struct Reader {
  const char* script;
  PythonEnvironment environment;
};

Reader reader_of(const std::string& file) {
  std::error_code ignored;
  const std::string allowed = fmt::format("allowed: {}, {}", imported_endings(), fmt::join(scene_endings, ", "));
  if (std::filesystem::is_directory(file, ignored))
    throw ExportError(fmt::format("{}: it is a folder; {}", file, allowed));
  if (!std::filesystem::is_regular_file(file, ignored)) throw ExportError(fmt::format("{}: no such file", file));
  if (has_ending(file, blender_endings)) return {"read_blender.py", blender_python};
  if (has_ending(file, scene_endings))
    return {ending_of(file) == ".xml" ? "read_libwetcloth.py" : "read_json.py", any_python};
  if (!has_ending(file, usd_endings)) throw ExportError(fmt::format("{}: cannot be imported; {}", file, allowed));
  return {"read_usd.py", usd_python};
}

std::vector<std::string> words_of(const ImportOptions& options) {
  std::vector<std::string> words;
  if (options.prim) words.push_back("--prim=" + *options.prim);
  if (options.fps) words.push_back(fmt::format("--fps={:.17g}", *options.fps));
  words.push_back("--");  // names may begin with dashes
  words.push_back(options.file);
  if (options.output) words.push_back(*options.output);
  return words;
}

}  // namespace

bool is_imported(const std::string& file) { return has_ending(file, usd_endings) || has_ending(file, blender_endings); }

std::string imported_endings() {
  return fmt::format("{}, {}", fmt::join(usd_endings, ", "), fmt::join(blender_endings, ", "));
}

int import_command(const ImportOptions& options) {
  if (has_ending(options.file, scene_endings) && (options.prim || options.fps))
    throw ExportError(
        fmt::format("{}: --{} applies to meshes, not to scenes", options.file, options.prim ? "prim" : "fps"));
  const Reader reader = reader_of(options.file);
  become_python(reader.script, words_of(options), reader.environment);
}

ImportedMesh imported_mesh(const std::string& file, const std::optional<std::string>& prim) {
  const Reader reader = reader_of(file);
  ImportOptions options;
  options.file = file;
  options.prim = prim;
  std::vector<std::string> words = words_of(options);
  words.insert(words.begin(), "--first");  // print the files' names and their rate alone
  std::istringstream printed(run_python(reader.script, words, reader.environment));
  ImportedMesh mesh;
  std::getline(printed, mesh.first);
  std::string pattern;
  double rate = 0;
  if (std::getline(printed, pattern) && printed >> rate) {
    mesh.sequence = pattern;
    mesh.per_second = rate;
  }
  return mesh;
}

}  // namespace drench
