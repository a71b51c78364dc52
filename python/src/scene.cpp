// Scenes through the loader of scene files.

#include <nanobind/stl/string.h>
#include <nanobind/stl/vector.h>

#include <fstream>
#include <iterator>

#include "module.hpp"
#include "scene/schema.hpp"

namespace drench::python {
namespace {

LoadedScene from_text(const std::string& text, const std::string& name, const std::vector<std::string>& overrides) {
  return {parse_scene(text, name, overrides), text, name, overrides};
}

LoadedScene from_file(const std::string& path, const std::vector<std::string>& overrides) {
  Scene scene = load_scene(path, overrides);
  std::ifstream in(path, std::ios::binary);
  return {std::move(scene), {std::istreambuf_iterator<char>(in), {}}, path, overrides};
}

}  // namespace

std::string LoadedScene::place_of(const std::string& key) const {
  try {
    return locate_in(text, path, overrides, key);
  } catch (const SceneError&) {
    return path;
  }
}

void bind_scene(nb::module_& m) {
  nb::class_<LoadedScene>(m, "Scene", "A scene that was read and checked.")
      .def_static("from_text", &from_text, nb::arg("text"), nb::arg("name") = "scene",
                  nb::arg("overrides") = std::vector<std::string>(),
                  "Reads a scene in YAML. Errors call it `name`, and mesh files are looked up beside that path.")
      .def_static("from_file", &from_file, nb::arg("path"), nb::arg("overrides") = std::vector<std::string>(),
                  "Reads a scene file. Each override is `key.path=value`.")
      .def(
          "to_yaml", [](const LoadedScene& s) { return to_yaml(s.scene); }, "The scene with every default written out.")
      .def_prop_ro(
          "path", [](const LoadedScene& s) { return s.path; }, "The file that it came from, or its name in errors.")
      .def_prop_ro(
          "step", [](const LoadedScene& s) { return s.scene.time.step; }, "time.step, s")
      .def_prop_ro(
          "end", [](const LoadedScene& s) { return s.scene.time.end; }, "time.end, s")
      .def_prop_ro(
          "output_every", [](const LoadedScene& s) { return s.scene.output.every; }, "output.every, s; 0: no frames")
      .def_prop_ro(
          "cloth_names",
          [](const LoadedScene& s) {
            std::vector<std::string> names;
            for (const ClothScene& cloth : s.scene.cloths) names.push_back(cloth.name);
            return names;
          },
          "The names of the cloths, in order.")
      .def_prop_ro(
          "particle_diameter", [](const LoadedScene& s) { return s.scene.fluid.spacing; }, "fluid.spacing, m");
  m.def("schema", &scene_reference, "Every key of a scene with range, unit, default and meaning, in Markdown.");
}

}  // namespace drench::python
