#include "app/cloth_texture.hpp"

#include <fmt/format.h>

#include <cstdio>
#include <optional>

#include "scene/load.hpp"
#include "setup/mesh_io.hpp"
#include "setup/setup_error.hpp"

namespace drench {
namespace {

/// The number of a file that outlives this program's image, and vanishes with the last program that has it open.
std::optional<int> open_file_of(const std::vector<float>& values) {
  std::FILE* file = std::tmpfile();
  if (!file) return std::nullopt;
  if (std::fwrite(values.data(), sizeof(float), values.size(), file) != values.size() || std::fflush(file) != 0)
    return std::nullopt;
  return fileno(file);
}

/// Of each corner of the triangles of a mesh file, u and v; empty without a file or without coordinates in it.
std::vector<float> coordinates_of(const std::string& file, const std::string& scene_path) {
  std::vector<float> values;
  if (file.empty()) return values;
  for (const auto& triangle : read_mesh(file, scene_path, {.texture = true}).texture)
    for (const auto& corner : triangle)
      for (const double coordinate : corner) values.push_back(static_cast<float>(coordinate));
  return values;
}

struct MeshFile {
  std::string name;  // for warnings
  std::string file;
};
/// `OPTION=NUMBER:DESCRIPTOR` for each of `files` that has coordinates.
std::vector<std::string> arguments_of(const std::string& option, const std::vector<MeshFile>& files,
                                      const std::string& scene_path, std::vector<std::string>& warnings) {
  std::vector<std::string> arguments;
  for (std::size_t k = 0; k < files.size(); ++k) {
    try {
      const std::vector<float> values = coordinates_of(files[k].file, scene_path);
      if (values.empty()) continue;
      if (const auto file = open_file_of(values))
        arguments.push_back(fmt::format("{}={}:{}", option, k, *file));
      else
        warnings.push_back("no texture coordinates: there is no room for a temporary file");
    } catch (const SetupError& e) {
      warnings.push_back(fmt::format("no texture coordinates of {}: {}", files[k].name, e.what()));
    }
  }
  return arguments;
}

}  // namespace

std::vector<std::string> texture_arguments(const std::filesystem::path& run_folder,
                                           std::vector<std::string>& warnings) {
  const std::string path = (run_folder / "scene.yaml").string();
  Scene scene;
  try {
    scene = load_scene(path);
  } catch (const SceneError& e) {
    warnings.push_back(fmt::format("no texture coordinates: {}", e.what()));
    return {};
  }
  std::vector<MeshFile> cloths, bodies;
  for (const ClothScene& cloth : scene.cloths) cloths.push_back({"cloth " + cloth.name, cloth.file});
  for (const BodyScene& body : scene.bodies) bodies.push_back({fmt::format("body {}", bodies.size()), body.file});
  std::vector<std::string> arguments = arguments_of("--texture", cloths, path, warnings);
  for (std::string& word : arguments_of("--body-texture", bodies, path, warnings)) arguments.push_back(std::move(word));
  return arguments;
}

}  // namespace drench
