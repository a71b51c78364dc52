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

std::vector<float> coordinates_of(const ClothScene& cloth, const std::string& scene_path) {
  std::vector<float> values;
  if (cloth.file.empty()) return values;
  for (const auto& triangle : read_mesh(cloth.file, scene_path, {.texture = true}).texture)
    for (const auto& corner : triangle)
      for (const double coordinate : corner) values.push_back(static_cast<float>(coordinate));
  return values;
}

}  // namespace

std::vector<std::string> texture_arguments(const std::filesystem::path& run_folder,
                                           std::vector<std::string>& warnings) {
  std::vector<std::string> arguments;
  const std::string path = (run_folder / "scene.yaml").string();
  Scene scene;
  try {
    scene = load_scene(path);
  } catch (const SceneError& e) {
    warnings.push_back(fmt::format("no texture coordinates: {}", e.what()));
    return arguments;
  }
  for (std::size_t c = 0; c < scene.cloths.size(); ++c) {
    try {
      const std::vector<float> values = coordinates_of(scene.cloths[c], path);
      if (values.empty()) continue;
      if (const auto file = open_file_of(values))
        arguments.push_back(fmt::format("--texture={}:{}", c, *file));
      else
        warnings.push_back("no texture coordinates: there is no room for a temporary file");
    } catch (const SetupError& e) {
      warnings.push_back(fmt::format("no texture coordinates of cloth {}: {}", scene.cloths[c].name, e.what()));
    }
  }
  return arguments;
}

}  // namespace drench
