#include "scene/load.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <set>
#include <tuple>

#include "scene/load_sections.hpp"
#include "scene/yaml_tree.hpp"

namespace drench {

namespace {

void read_time(Section& s, TimeScene& time) {
  s.number("step", time.step, "[1e-9, 1]", "s");
  s.number("end", time.end, "[1e-9, 1e6]", "s");
  s.choice<TimeMode>("mode", time.mode, {{"fixed", TimeMode::fixed}, {"cfl", TimeMode::cfl}});
  s.number("cfl", time.cfl, "[0.001, 1]", "1");
}

void read_field(Section& s, FieldScene& field) {
  field.present = true;
  s.required({"rate"});
  s.numbers("center", field.center, coordinate_range, "m");
  s.numbers("rate", field.rate, "[0, 1000]", "1/s");
  check_not_zero(s, "rate", field.rate);
}

void read_output(Section& s, OutputScene& output) {
  s.number("every", output.every, "[0, 1e6]", "s");
  s.number("checkpoint_every", output.checkpoint_every, "[0, 1e6]", "s");
  s.boolean("measures", output.measures);
  s.boolean("surface", output.surface);
  s.number("surface_spacing", output.surface_spacing, "[0.25, 1]", "spacings");
}

/// A preset says where the switches stand that `processes` leaves alone.
void read_preset(Section& s, ProcessScene& processes) {
  enum class Preset { none, baseline } preset = Preset::none;
  s.choice<Preset>("preset", preset, {{"none", Preset::none}, {"baseline", Preset::baseline}});
  if (preset == Preset::baseline) processes.direction = processes.saturation_control = false;
}

void read_processes(Section& s, ProcessScene& processes) {
  s.boolean("direction", processes.direction);
  s.boolean("saturation_control", processes.saturation_control);
  s.boolean("absorption", processes.absorption);
  s.boolean("emission", processes.emission);
  s.boolean("diffusion", processes.diffusion);
}

void read_neighbors(Section& s, Scene& scene) {
  s.choice<SortMethod>("sort", scene.sort,
                       {{"auto", SortMethod::automatic},
                        {"counting", SortMethod::counting},
                        {"radix", SortMethod::radix},
                        {"bitonic", SortMethod::bitonic},
                        {"bitonic_naive", SortMethod::bitonic_naive}});
  s.boolean("through_cloth", scene.through_cloth);
}

// ---- fluid

void read_solver(Section& s, FluidSolverScene& solver) {
  s.number("density_error", solver.density_error, "[1e-15, 0.5]", "1");
  s.number("divergence_error", solver.divergence_error, "[1e-15, 0.5]", "1");
  s.integer("max_iterations", solver.max_iterations, "[1, 100000]", "iterations");
  s.integer("min_iterations", solver.min_iterations, "[0, 100000]", "iterations");
  s.check(solver.min_iterations <= solver.max_iterations, s.has("min_iterations") ? "min_iterations" : "max_iterations",
          fmt::format("min_iterations ({}) is above max_iterations ({}); allowed: at most that", solver.min_iterations,
                      solver.max_iterations));
  s.number("density_correction", solver.density_correction, "[0.5, 1]", "1");
}

void read_micropolar(Section& s, MicropolarScene& micropolar) {
  micropolar.present = true;
  s.number("transfer", micropolar.transfer, "(0, 10]", "m²/s");
  s.number("inertia", micropolar.inertia, "[0.01, 1e4]", "spacings²");
  s.number("viscosity", micropolar.viscosity, "[0, 10]", "m²/s");
  s.number("reaction", micropolar.reaction, "[0, 1]", "1");
}

void read_block(Section& s, BlockScene& block) {
  read_box(s, block.box);
  s.numbers("velocity", block.velocity, speed_range, "m/s");
}

void read_jet(Section& s, JetScene& jet) {
  s.required({"center", "radius", "velocity"});
  s.numbers("center", jet.center, coordinate_range, "m");
  s.number("radius", jet.radius, "[1e-6, 100]", "m");
  s.numbers("velocity", jet.velocity, speed_range, "m/s");
  s.number("start", jet.start, "[0, 1e6]", "s");
  s.number("end", jet.end, "[0, inf]", "s");
  check_not_zero(s, "velocity", jet.velocity);
  s.check(jet.start < jet.end, s.has("end") ? "end" : "start",
          fmt::format("the jet ends at {} s and starts at {} s; allowed: an end after the start", jet.end, jet.start));
}

void read_source(Section& s, FluidScene& fluid) {
  s.one_of({"block", "jet"});
  s.entry("block", fluid.blocks, read_block);
  s.entry("jet", fluid.jets, read_jet);
}

void read_fluid(Section& s, FluidScene& fluid) {
  s.number("spacing", fluid.spacing, "[1e-6, 10]", "m");
  s.number("density", fluid.density, "[1, 30000]", "kg/m³");
  s.number("viscosity", fluid.viscosity, "[0, 100]", "m²/s");
  s.number("surface_tension", fluid.surface_tension, "[0, 10]", "N/m");
  s.choice<KernelKind>(
      "kernel", fluid.kernel,
      {{"cubic", KernelKind::cubic}, {"wendland", KernelKind::wendland}, {"poly6", KernelKind::poly6}});
  s.number("support", fluid.support, "[1.8, 4]", "spacings");  // below, a full neighbourhood has too few (kernel.hpp)
  s.section("micropolar", fluid.micropolar, read_micropolar);
  s.section("solver", fluid.solver, read_solver);
  s.each("sources", fluid, read_source);
}

// ---- the whole; src/scene/load_cloth.cpp and load_bodies.cpp have the rest

void check_scene(Section& s, const Scene& scene) {
  s.check(scene.fluid.present || !scene.cloths.empty(), "fluid",
          "neither fluid nor cloth stands in the scene; allowed: at least one of them");
  s.check(scene.fluid.present || !scene.field.present, "field",
          "acts on liquid, and the scene has none; allowed: only beside the key fluid");
  s.check(scene.fluid.present || !scene.output.surface, "output.surface",
          "is that of the liquid, and the scene has none; allowed: true only beside the key fluid");
  s.check(!s.has("cloth_solver") || !scene.cloths.empty(), "cloth_solver",
          "moves cloth, and the scene has none; allowed: only beside the key cloth");
  const bool porous = std::any_of(scene.cloths.begin(), scene.cloths.end(),
                                  [](const ClothScene& cloth) { return cloth.porous.present; });
  s.check(!scene.fluid.present || !scene.fluid.blocks.empty() || !scene.fluid.jets.empty() || porous, "fluid.sources",
          "is missing; allowed: a list of maps; only a scene with porous cloth, which can drip, does without");
  for (const char* key : {"preset", "processes"})
    s.check(!s.has(key) || porous, key,
            "is for cloth that takes up liquid, and the scene has none; allowed: only beside a cloth's key porous");
  if (const auto often = too_often(scene)) s.check(false, often->first, often->second);
  std::set<std::string> names;
  for (std::size_t i = 0; i < scene.cloths.size(); ++i) {
    const std::optional<double>& samples = scene.cloths[i].sample_spacing;
    s.check(!samples || !scene.fluid.present || *samples <= scene.fluid.spacing,
            fmt::format("cloth.{}.sample_spacing", i),
            fmt::format("{} is more than fluid.spacing; allowed: at most {} (m)", samples.value_or(0),
                        scene.fluid.spacing));
    s.check(
        names.insert(scene.cloths[i].name).second, fmt::format("cloth.{}.name", i),
        fmt::format("a cloth before it is named '{}' too; allowed: a name of its own for each", scene.cloths[i].name));
  }
  for (std::size_t i = 0; i < scene.bodies.size(); ++i) {
    const char* kind = scene.bodies[i].kind == BodyScene::Kind::sphere ? "sphere" : "box";
    s.not_available(scene.bodies[i].dynamic && !scene.fluid.present, fmt::format("bodies.{}.{}.dynamic", i, kind),
                    "a dynamic body in a scene without fluid", "false, or a scene with fluid");
  }
}

void read_scene(Section& s, Scene& scene) {
  s.required({"drench"});
  s.integer("drench", scene.version, "[1, 1]", "(the format's version)");
  s.section("time", scene.time, read_time);
  s.numbers("gravity", scene.gravity, "[-1000, 1000]", "m/s²");
  s.section("field", scene.field, read_field);
  s.section("domain", scene.domain, read_box);
  s.section("output", scene.output, read_output);
  read_preset(s, scene.processes);
  s.section("processes", scene.processes, read_processes);
  s.section("neighbors", scene, read_neighbors);
  scene.fluid.present = s.section("fluid", scene.fluid, read_fluid);
  s.section("cloth_solver", scene.cloth_solver, read_cloth_solver);
  s.list("cloth", scene.cloths, read_cloth);
  s.list("bodies", scene.bodies, read_body);
  check_scene(s, scene);
}

/// The file's text, one byte over the limit at most.
std::string read_text(const std::string& path) {
  std::error_code error;
  if (std::filesystem::is_directory(path, error)) throw SceneError(path, "is a folder; allowed: a scene file");
  errno = 0;
  std::ifstream stream(path, std::ios::binary);
  if (!stream) throw SceneError(path, fmt::format("cannot be read: {}", std::strerror(errno)));
  std::string text;
  std::string part(std::size_t{1} << 16, '\0');
  while (text.size() <= yaml::max_bytes) {
    stream.read(part.data(), static_cast<std::streamsize>(part.size()));
    text.append(part, 0, static_cast<std::size_t>(stream.gcount()));
    if (!stream) break;
  }
  if (stream.bad()) throw SceneError(path, "cannot be read to its end");
  return text;
}

}  // namespace

std::optional<std::pair<std::string, std::string>> too_often(const Scene& scene) {
  constexpr double most = 1e9;
  const std::tuple<const char*, const char*, double> parts[] = {
      {"time.step", "steps", scene.time.step},
      {"output.every", "frames", scene.output.every},
      {"output.checkpoint_every", "checkpoints", scene.output.checkpoint_every}};
  for (const auto& [key, what, interval] : parts)
    if (interval > 0 && scene.time.end / interval > most)
      return std::pair(std::string(key), fmt::format("{} s make {:.3g} {} until {} s; allowed: at most {:.0e}",
                                                     interval, scene.time.end / interval, what, scene.time.end, most));
  return {};
}

Scene parse_scene(const std::string& yaml_text, const std::string& path_for_messages,
                  const std::vector<std::string>& overrides) {
  yaml::Value root = yaml::parse(yaml_text, path_for_messages);
  if (root.kind == yaml::Value::Kind::null && overrides.empty()) {
    throw SceneError(path_for_messages + ":1:1", "scene: is empty; allowed: a map that begins with drench: 1");
  }
  for (const std::string& override_text : overrides) yaml::apply_override(root, override_text);
  Scene scene;
  scene.path = path_for_messages;
  Section section(root, "", std::filesystem::path(path_for_messages).parent_path().string());
  read_scene(section, scene);
  section.done();
  return scene;
}

Schema scene_schema() {
  Schema schema;
  Section section(schema, "");
  Scene scene;
  read_scene(section, scene);
  return schema;
}

Scene load_scene(const std::string& path, const std::vector<std::string>& overrides) {
  return parse_scene(read_text(path), path, overrides);
}

std::string locate_in(const std::string& yaml_text, const std::string& path_for_messages,
                      const std::vector<std::string>& overrides, const std::string& key) {
  yaml::Value root = yaml::parse(yaml_text, path_for_messages);
  for (const std::string& override_text : overrides) yaml::apply_override(root, override_text);
  return root.place_of(key).text() + ": " + (key.empty() ? "scene" : key);
}

std::string locate(const std::string& path, const std::vector<std::string>& overrides, const std::string& key) {
  return locate_in(read_text(path), path, overrides, key);
}

}  // namespace drench
