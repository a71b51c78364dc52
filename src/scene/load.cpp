#include "scene/load.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <set>

#include "scene/reader.hpp"
#include "scene/yaml_tree.hpp"

namespace drench {

namespace {

constexpr const char* coordinate = "[-10000, 10000]";  // m: far beyond any scene, near enough for float
constexpr const char* speed = "[-1000, 1000]";         // m/s: below the speed of sound in water

bool is_zero(const Vec3& v) { return v[0] == 0 && v[1] == 0 && v[2] == 0; }

void check_not_zero(Section& s, const char* key, const Vec3& v) {
  s.check(!is_zero(v), key, "has length 0; allowed: a vector that points somewhere");
}

void read_box(Section& s, Box& box) {
  s.required({"min", "max"});
  s.numbers("min", box.min, coordinate, "m");
  s.numbers("max", box.max, coordinate, "m");
  for (std::size_t i = 0; i < 3; ++i) {
    s.check(box.min[i] < box.max[i], fmt::format("max.{}", i),
            fmt::format("{} is not above min ({}); allowed: more than min, in m", box.max[i], box.min[i]));
  }
}

void read_time(Section& s, TimeScene& time) {
  s.number("step", time.step, "(0, 1]", "s");
  s.number("end", time.end, "(0, 1e6]", "s");
  s.choice<TimeMode>("mode", time.mode, {{"fixed", TimeMode::fixed}, {"cfl", TimeMode::cfl}});
  s.number("cfl", time.cfl, "(0, 1]", "1");
}

void read_field(Section& s, FieldScene& field) {
  field.present = true;
  s.required({"rate"});
  s.numbers("center", field.center, coordinate, "m");
  s.numbers("rate", field.rate, "[0, 1000]", "1/s");
  check_not_zero(s, "rate", field.rate);
}

void read_output(Section& s, OutputScene& output) {
  s.number("every", output.every, "[0, 1e6]", "s");
  s.number("checkpoint_every", output.checkpoint_every, "[0, 1e6]", "s");
  s.boolean("measures", output.measures);
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
  s.number("density_error", solver.density_error, "(0, 0.5]", "1");
  s.number("divergence_error", solver.divergence_error, "(0, 0.5]", "1");
  s.integer("max_iterations", solver.max_iterations, "[1, 100000]", "iterations");
  s.integer("min_iterations", solver.min_iterations, "[0, 100000]", "iterations");
  s.check(solver.min_iterations <= solver.max_iterations, s.has("min_iterations") ? "min_iterations" : "max_iterations",
          fmt::format("min_iterations ({}) is above max_iterations ({}); allowed: at most that", solver.min_iterations,
                      solver.max_iterations));
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
  s.numbers("velocity", block.velocity, speed, "m/s");
}

void read_jet(Section& s, JetScene& jet) {
  s.required({"center", "radius", "velocity"});
  s.numbers("center", jet.center, coordinate, "m");
  s.number("radius", jet.radius, "(0, 100]", "m");
  s.numbers("velocity", jet.velocity, speed, "m/s");
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
  s.number("spacing", fluid.spacing, "(0, 10]", "m");
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

// ---- cloth

void read_grid(Section& s, GridScene& grid) {
  s.numbers("size", grid.size, "(0, 1000]", "m");
  s.integers("nodes", grid.nodes, "[2, 4096]", "nodes");
}

void read_cloth_mesh(Section& s, ClothScene& cloth) {
  GridScene grid;
  if (s.section("grid", grid, read_grid)) cloth.grid = grid;
  s.mesh_file("file", cloth.file);
  s.number("scale", cloth.scale, "(0, 1e6]", "1");
  s.check(s.has("grid") || s.has("file"), "grid", "neither grid nor file stands here; allowed: exactly one of them");
  s.check(!s.has("grid") || !s.has("file"), "file", "stands beside grid; allowed: exactly one of them");
  s.check(!s.has("grid") || !s.has("scale"), "scale", "is for mesh files; allowed: the size of the grid, in m");
}

void read_rotate(Section& s, ClothScene& cloth) {
  s.numbers("axis", cloth.rotate_axis, "[-1e6, 1e6]", "1");
  s.number("degrees", cloth.rotate_degrees, "[-3600, 3600]", "degrees");
  check_not_zero(s, "axis", cloth.rotate_axis);
}

void read_place(Section& s, ClothScene& cloth) {
  s.numbers("position", cloth.position, coordinate, "m");
  s.section("rotate", cloth, read_rotate);
}

void read_spin(Section& s, SpinScene& spin) {
  s.numbers("axis", spin.axis, "[-1e6, 1e6]", "1");
  s.number("degrees_per_second", spin.degrees_per_second, "[-1e5, 1e5]", "degrees/s");
  check_not_zero(s, "axis", spin.axis);
}

void read_pin_spin(Section& s, PinScene& pin) {
  read_spin(s, pin.spin);
  s.numbers("center", pin.center, coordinate, "m");
}

/// How pins move.
void read_pin_motion(Section& s, PinScene& pin) {
  s.numbers("velocity", pin.velocity, speed, "m/s");
  s.section("spin", pin, read_pin_spin);
  s.number("start", pin.start, "[0, 1e6]", "s");
  s.number("end", pin.end, "[0, inf]", "s");
  s.check(
      pin.start < pin.end, s.has("end") ? "end" : "start",
      fmt::format("the motion ends at {} s and starts at {} s; allowed: an end after the start", pin.end, pin.start));
}

void read_pin(Section& s, PinScene& pin) {
  const std::string kind = s.one_of({"corners", "edges", "box", "nodes"}, {"velocity", "spin", "start", "end"});
  if (s.flag("corners")) pin.kind = PinScene::Kind::corners;
  if (s.flag("edges")) pin.kind = PinScene::Kind::edges;
  if (s.section("box", pin.box, read_box)) pin.kind = PinScene::Kind::box;
  s.integers("nodes", pin.nodes, "[0, 2147483646]", "(the number of a node)");
  if (kind == "nodes") pin.kind = PinScene::Kind::nodes;
  read_pin_motion(s, pin);
}

void read_saturation(Section& s, SaturationScene& saturation) {
  s.required({"box", "value"});
  s.section("box", saturation.box, read_box);
  s.number("value", saturation.value, "[0, 10]", "1");
}

void read_porous(Section& s, PorousScene& porous) {
  porous.present = true;
  s.number("solid_fraction", porous.solid_fraction, "[0, 1)", "1");
  s.number("absorption", porous.absorption, "[0, 100]", "m²/s");
  s.number("uptake_velocity", porous.uptake_velocity, "[0, 100]", "m/s");
  s.number("max_saturation", porous.max_saturation, "[1, 10]", "1");
  s.number("virtual_pressure", porous.virtual_pressure, "[0, 1e5]", "m/s²");
  s.number("emission_angle", porous.emission_angle, "(0, 180)", "degrees");
  s.number("emission_velocity", porous.emission_velocity, "[0, 100]", "m/s");
  s.number("emission_ramp", porous.emission_ramp, "[0, 100]", "s");
  s.number("diffusivity", porous.diffusivity, "[0, 1]", "m²/s");
  s.choice<DiffusionLaw>("diffusion", porous.diffusion,
                         {{"linear", DiffusionLaw::linear}, {"degenerate", DiffusionLaw::degenerate}});
  s.number("capillary_height", porous.capillary_height, "(0, 1000]", "m");
  s.number("adhesion", porous.adhesion, "[0, 10]", "N/m");
  s.boolean("contact_wicking", porous.contact_wicking);
  s.check(!porous.contact_wicking || porous.diffusivity > 0, "contact_wicking",
          "passes liquid on as well as the fabric conducts it, and its diffusivity is 0; allowed: diffusivity above 0");
}

void check_saturations(Section& s, const char* key, const std::vector<SaturationScene>& boxes,
                       const ClothScene& cloth) {
  s.check(boxes.empty() || cloth.porous.present, key,
          "is for a cloth that takes up liquid; allowed: only beside the key porous");
  for (std::size_t i = 0; i < boxes.size(); ++i) {
    s.check(boxes[i].value <= cloth.porous.max_saturation, fmt::format("{}.{}.value", key, i),
            fmt::format("{} is above porous.max_saturation; allowed: [0, {}] (no unit)", boxes[i].value,
                        cloth.porous.max_saturation));
  }
}

/// A key that has no default of its own.
void read_wet(Section& s, const char* key, std::optional<double>& out, const ClothScene& cloth, const char* range,
              const char* unit) {
  s.number(key, out, range, unit);
  s.check(!out || cloth.porous.present, key,
          "is for a cloth that takes up liquid; allowed: only beside the key porous");
}

void check_pins(Section& s, const ClothScene& cloth) {
  for (std::size_t i = 0; i < cloth.pins.size(); ++i) {
    s.check(cloth.dynamics || !moves(cloth.pins[i]), fmt::format("pin.{}", i),
            "moves pins of a cloth that does not move; allowed: only with dynamics: true");
  }
  if (!cloth.grid) return;
  const Index count = cloth.grid->nodes[0] * cloth.grid->nodes[1];
  for (std::size_t i = 0; i < cloth.pins.size(); ++i) {
    for (std::size_t k = 0; k < cloth.pins[i].nodes.size(); ++k) {
      s.check(cloth.pins[i].nodes[k] < count, fmt::format("pin.{}.nodes.{}", i, k),
              fmt::format("{} is not a node of the grid; allowed: [0, {}]", cloth.pins[i].nodes[k], count - 1));
    }
  }
}

void read_cloth(Section& s, ClothScene& cloth) {
  s.required({"mesh"});
  s.text("name", cloth.name);
  s.section("mesh", cloth, read_cloth_mesh);
  s.section("place", cloth, read_place);
  s.number("areal_density", cloth.areal_density, "(0, 1000]", "kg/m²");
  s.number("thickness", cloth.thickness, "(0, 1]", "m");
  s.number("stretch", cloth.stretch, "(0, 1e9]", "N/m");
  s.number("bend", cloth.bend, "[0, 1e6]", "N·m");
  s.number("damping", cloth.damping, "[0, 1e6]", "1/s");
  s.number("strain_damping", cloth.strain_damping, "[0, 100]", "s");
  s.number("friction", cloth.friction, "[0, 10]", "1");
  s.number("strain_limit", cloth.strain_limit, "[0, 1)", "1");
  s.number("adhesion", cloth.adhesion, "[0, 10]", "N/m");
  s.list("pin", cloth.pins, read_pin);
  s.boolean("self_collision", cloth.self_collision);
  s.boolean("dynamics", cloth.dynamics);
  s.list("initial_saturation", cloth.initial_saturation, read_saturation);
  s.list("hold_saturation", cloth.hold_saturation, read_saturation);
  s.section("porous", cloth.porous, read_porous);
  read_wet(s, "friction_wet", cloth.friction_wet, cloth, "[0, 10]", "1");
  read_wet(s, "damping_wet", cloth.damping_wet, cloth, "[0, 1e6]", "1/s");
  check_pins(s, cloth);
  check_saturations(s, "initial_saturation", cloth.initial_saturation, cloth);
  check_saturations(s, "hold_saturation", cloth.hold_saturation, cloth);
}

void read_cloth_solver(Section& s, ClothSolverScene& solver) {
  s.choice<ClothMethod>("method", solver.method, {{"pd", ClothMethod::pd}, {"xpbd", ClothMethod::xpbd}});
  s.number("tolerance", solver.tolerance, "(0, 0.5]", "1");
  s.integer("max_iterations", solver.max_iterations, "[1, 100000]", "iterations");
}

// ---- bodies

/// What all bodies have: how they move.
void read_motion(Section& s, BodyScene& body) {
  s.numbers("velocity", body.velocity, speed, "m/s");
  s.section("spin", body.spin, read_spin);
  s.boolean("dynamic", body.dynamic);
  s.number("density", body.density, "[1, 30000]", "kg/m³");
  s.check(body.dynamic || !s.has("density"), "density",
          "is for a body that floats; allowed: only beside dynamic: true");
  const bool can_float = body.kind == BodyScene::Kind::sphere || (body.kind == BodyScene::Kind::box && !body.inside);
  s.not_available(body.dynamic && !can_float, "dynamic", "a plane, mesh or container that the liquid moves",
                  "false, or a sphere or a box that is not a container");
}
void read_adhesion(Section& s, BodyScene& body) {
  s.number("adhesion", body.adhesion, "[0, 10]", "N/m");
  s.not_available(body.dynamic && body.adhesion > 0, "adhesion", "adhesion to a body that floats", "0 N/m");
}

void read_body_box(Section& s, BodyScene& body) {
  body.kind = BodyScene::Kind::box;
  read_box(s, body.box);
  s.boolean("inside", body.inside);
  read_motion(s, body);
  read_adhesion(s, body);
}

void read_sphere(Section& s, BodyScene& body) {
  body.kind = BodyScene::Kind::sphere;
  s.required({"center", "radius"});
  s.numbers("center", body.center, coordinate, "m");
  s.number("radius", body.radius, "(0, 10000]", "m");
  read_motion(s, body);
  read_adhesion(s, body);
}

void read_plane(Section& s, BodyScene& body) {
  body.kind = BodyScene::Kind::plane;
  s.required({"point", "normal"});
  s.numbers("point", body.point, coordinate, "m");
  s.numbers("normal", body.normal, "[-1e6, 1e6]", "1");
  check_not_zero(s, "normal", body.normal);
  read_motion(s, body);
  read_adhesion(s, body);
}

void read_body_mesh(Section& s, BodyScene& body) {
  body.kind = BodyScene::Kind::mesh;
  s.required({"file"});
  s.mesh_file("file", body.file);
  s.number("scale", body.scale, "(0, 1e6]", "1");
  s.numbers("position", body.position, coordinate, "m");
  read_motion(s, body);
  read_adhesion(s, body);
}

void read_body(Section& s, BodyScene& body) {
  s.one_of({"box", "sphere", "plane", "mesh"});
  s.section("box", body, read_body_box);
  s.section("sphere", body, read_sphere);
  s.section("plane", body, read_plane);
  s.section("mesh", body, read_body_mesh);
}

// ---- the whole

void check_scene(Section& s, const Scene& scene) {
  s.check(scene.fluid.present || !scene.cloths.empty(), "fluid",
          "neither fluid nor cloth stands in the scene; allowed: at least one of them");
  s.check(scene.fluid.present || !scene.field.present, "field",
          "acts on liquid, and the scene has none; allowed: only beside the key fluid");
  s.check(!s.has("cloth_solver") || !scene.cloths.empty(), "cloth_solver",
          "moves cloth, and the scene has none; allowed: only beside the key cloth");
  const bool porous = std::any_of(scene.cloths.begin(), scene.cloths.end(),
                                  [](const ClothScene& cloth) { return cloth.porous.present; });
  s.check(!scene.fluid.present || !scene.fluid.blocks.empty() || !scene.fluid.jets.empty() || porous, "fluid.sources",
          "is missing; allowed: a list of maps; only a scene with porous cloth, which can drip, does without");
  for (const char* key : {"preset", "processes"})
    s.check(!s.has(key) || porous, key,
            "is for cloth that takes up liquid, and the scene has none; allowed: only beside a cloth's key porous");
  std::set<std::string> names;
  for (std::size_t i = 0; i < scene.cloths.size(); ++i) {
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
