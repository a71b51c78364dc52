// Reads the cloths of a scene.

#include <fmt/format.h>

#include "scene/load_sections.hpp"

namespace drench {
namespace {

void read_grid(Section& s, GridScene& grid) {
  s.numbers("size", grid.size, "[1e-6, 1000]", "m");
  s.integers("nodes", grid.nodes, "[2, 4096]", "nodes");
}

void read_cloth_mesh(Section& s, ClothScene& cloth) {
  GridScene grid;
  if (s.section("grid", grid, read_grid)) cloth.grid = grid;
  s.mesh_file("file", cloth.file);
  s.number("scale", cloth.scale, "[1e-9, 1e6]", "1");
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
  s.numbers("position", cloth.position, coordinate_range, "m");
  s.section("rotate", cloth, read_rotate);
}

void read_pin_spin(Section& s, PinScene& pin) {
  read_spin(s, pin.spin);
  s.numbers("center", pin.center, coordinate_range, "m");
}

/// How pins move.
void read_pin_motion(Section& s, PinScene& pin) {
  s.numbers("velocity", pin.velocity, speed_range, "m/s");
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
  s.number("emission_angle", porous.emission_angle, "[1, 179]", "degrees");
  s.number("emission_velocity", porous.emission_velocity, "[0, 100]", "m/s");
  s.number("emission_ramp", porous.emission_ramp, "[0, 100]", "s");
  s.number("diffusivity", porous.diffusivity, "[0, 1]", "m²/s");
  s.choice<DiffusionLaw>("diffusion", porous.diffusion,
                         {{"linear", DiffusionLaw::linear}, {"degenerate", DiffusionLaw::degenerate}});
  s.number("capillary_height", porous.capillary_height, "[1e-6, 1000]", "m");
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

}  // namespace

void read_cloth(Section& s, ClothScene& cloth) {
  s.required({"mesh"});
  s.text("name", cloth.name);
  s.section("mesh", cloth, read_cloth_mesh);
  s.section("place", cloth, read_place);
  s.number("areal_density", cloth.areal_density, "[1e-4, 1000]", "kg/m²");
  s.number("thickness", cloth.thickness, "[1e-6, 1]", "m");
  s.number("stretch", cloth.stretch, "[0.001, 1e9]", "N/m");
  s.number("bend", cloth.bend, "[0, 1e6]", "N·m");
  s.number("damping", cloth.damping, "[0, 1e6]", "1/s");
  s.number("strain_damping", cloth.strain_damping, "[0, 100]", "s");
  s.number("friction", cloth.friction, "[0, 10]", "1");
  s.number("strain_limit", cloth.strain_limit, "[0, 0.99]", "1");
  s.number("adhesion", cloth.adhesion, "[0, 10]", "N/m");
  s.number("sample_spacing", cloth.sample_spacing, "[1e-6, 1000]", "m");
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
  s.number("tolerance", solver.tolerance, "[1e-15, 0.5]", "1");
  s.integer("max_iterations", solver.max_iterations, "[1, 100000]", "iterations");
}

}  // namespace drench
