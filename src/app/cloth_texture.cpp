#include "app/cloth_texture.hpp"

#include <fmt/format.h>

#include <cstdio>
#include <functional>
#include <optional>

#include "scene/load.hpp"
#include "setup/body_geometry.hpp"
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

/// Coordinates of the corners of a mesh's triangles; `untextured` as in SurfaceMesh.
using Coordinates = std::function<TextureCorners(std::size_t& untextured)>;
struct MeshFile {
  std::string name;  // for warnings
  Coordinates coordinates;
};

std::vector<float> numbers_of(const TextureCorners& texture) {
  std::vector<float> values;
  for (const auto& triangle : texture)
    for (const auto& corner : triangle)
      for (const double coordinate : corner) values.push_back(static_cast<float>(coordinate));
  return values;
}

/// `OPTION=NUMBER:DESCRIPTOR` for each of `files` that has coordinates.
std::vector<std::string> arguments_of(const std::string& option, const std::vector<MeshFile>& files,
                                      std::vector<std::string>& warnings) {
  std::vector<std::string> arguments;
  for (std::size_t k = 0; k < files.size(); ++k) {
    try {
      std::size_t untextured = 0;
      const std::vector<float> values = numbers_of(files[k].coordinates(untextured));
      if (untextured > 0)
        warnings.push_back(
            fmt::format("no texture coordinates of {}: {} corners in its mesh file have none; allowed: "
                        "all corners, or none",
                        files[k].name, untextured));
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
  for (const ClothScene& cloth : scene.cloths)
    cloths.push_back({"cloth " + cloth.name, [&](std::size_t& untextured) {
                        if (cloth.file.empty()) return TextureCorners();
                        SurfaceMesh mesh = read_mesh(cloth.file, path, {.texture = true});
                        untextured = mesh.untextured;
                        return std::move(mesh.texture);
                      }});
  for (const BodyScene& body : scene.bodies)
    bodies.push_back({fmt::format("body {}", bodies.size()), [&](std::size_t& untextured) {
                        return body.file.empty() ? TextureCorners() : body_texture(body, path, untextured);
                      }});
  std::vector<std::string> arguments = arguments_of("--texture", cloths, warnings);
  for (std::string& word : arguments_of("--body-texture", bodies, warnings)) arguments.push_back(std::move(word));
  return arguments;
}

}  // namespace drench
