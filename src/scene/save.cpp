// Scene → YAML, in the order of the scene file's own documentation. What is read in load.cpp is written here.

#include <fmt/format.h>

#include <iterator>
#include <string>

#include "scene/load.hpp"
#include "scene/yaml_tree.hpp"

namespace drench {

namespace {

using yaml::text;

std::string quoted(const std::string& words) {
  std::string all;
  for (const char c : words) {
    const auto byte = static_cast<unsigned char>(c);
    if (c == '"' || c == '\\') all += '\\';
    if (byte < 0x20 || byte == 0x7f) {
      all += fmt::format("\\x{:02x}", byte);
    } else {
      all += c;
    }
  }
  return "\"" + all + "\"";
}

std::string corners(const Box& box) { return fmt::format("min: {}, max: {}", text(box.min), text(box.max)); }

const char* word(SortMethod sort) {
  switch (sort) {
    case SortMethod::counting:
      return "counting";
    case SortMethod::radix:
      return "radix";
    case SortMethod::bitonic:
      return "bitonic";
    case SortMethod::bitonic_naive:
      return "bitonic_naive";
    case SortMethod::automatic:
      break;
  }
  return "auto";
}

const char* word(KernelKind kernel) {
  switch (kernel) {
    case KernelKind::wendland:
      return "wendland";
    case KernelKind::poly6:
      return "poly6";
    case KernelKind::cubic:
      break;
  }
  return "cubic";
}

/// Lines of YAML, appended one by one.
class Writer {
 public:
  template <class... Args>
  void line(fmt::format_string<Args...> format, Args&&... args) {
    fmt::format_to(std::back_inserter(yaml_), format, std::forward<Args>(args)...);
    yaml_ += '\n';
  }
  std::string take() { return std::move(yaml_); }

 private:
  std::string yaml_;
};

void write_fluid(Writer& out, const FluidScene& fluid) {
  out.line("fluid:");
  out.line("  spacing: {}  # m", text(fluid.spacing));
  out.line("  density: {}  # kg/m³", text(fluid.density));
  out.line("  viscosity: {}  # m²/s", text(fluid.viscosity));
  out.line("  surface_tension: {}  # N/m", text(fluid.surface_tension));
  out.line("  kernel: {}", word(fluid.kernel));
  out.line("  support: {}  # h / spacing", text(fluid.support));
  if (const MicropolarScene& spin = fluid.micropolar; spin.present)
    out.line("  micropolar: {{transfer: {}, inertia: {}, viscosity: {}, reaction: {}}}  # m²/s, spacings², m²/s, 1",
             text(spin.transfer), text(spin.inertia), text(spin.viscosity), text(spin.reaction));
  out.line(
      "  solver: {{density_error: {}, divergence_error: {}, max_iterations: {}, min_iterations: {}, "
      "density_correction: {}}}",
      text(fluid.solver.density_error), text(fluid.solver.divergence_error), fluid.solver.max_iterations,
      fluid.solver.min_iterations, text(fluid.solver.density_correction));
  if (!fluid.blocks.empty() || !fluid.jets.empty()) out.line("  sources:");
  for (const BlockScene& block : fluid.blocks) {
    out.line("    - block: {{{}, velocity: {}}}", corners(block.box), text(block.velocity));
  }
  for (const JetScene& jet : fluid.jets) {
    out.line("    - jet: {{center: {}, radius: {}, velocity: {}, start: {}, end: {}}}", text(jet.center),
             text(jet.radius), text(jet.velocity), text(jet.start), text(jet.end));
  }
}

/// The motion of pins, "" where all of it is as by default.
std::string motion(const PinScene& pin) {
  const PinScene still;
  if (!moves(pin) && pin.spin.axis == still.spin.axis && pin.center == still.center && pin.start == still.start &&
      pin.end == still.end)
    return "";
  return fmt::format(", velocity: {}, spin: {{axis: {}, degrees_per_second: {}, center: {}}}, start: {}, end: {}",
                     text(pin.velocity), text(pin.spin.axis), text(pin.spin.degrees_per_second), text(pin.center),
                     text(pin.start), text(pin.end));
}

void write_pin(Writer& out, const PinScene& pin) {
  switch (pin.kind) {
    case PinScene::Kind::corners:
      return out.line("      - {{corners: true{}}}", motion(pin));
    case PinScene::Kind::edges:
      return out.line("      - {{edges: true{}}}", motion(pin));
    case PinScene::Kind::box:
      return out.line("      - {{box: {{{}}}{}}}", corners(pin.box), motion(pin));
    case PinScene::Kind::nodes:
      return out.line("      - {{nodes: [{}]{}}}", fmt::join(pin.nodes, ", "), motion(pin));
  }
}

void write_saturation(Writer& out, const char* key, const std::vector<SaturationScene>& boxes) {
  if (boxes.empty()) return;
  out.line("    {}:", key);
  for (const auto& box : boxes) out.line("      - {{box: {{{}}}, value: {}}}", corners(box.box), text(box.value));
}

void write_porous(Writer& out, const PorousScene& porous) {
  out.line("    porous:");
  out.line("      solid_fraction: {}", text(porous.solid_fraction));
  out.line("      absorption: {}  # m²/s", text(porous.absorption));
  out.line("      uptake_velocity: {}  # m/s; above 0 it replaces absorption", text(porous.uptake_velocity));
  out.line("      max_saturation: {}", text(porous.max_saturation));
  out.line("      virtual_pressure: {}  # m/s²", text(porous.virtual_pressure));
  out.line("      emission_angle: {}  # degrees", text(porous.emission_angle));
  out.line("      emission_velocity: {}  # m/s", text(porous.emission_velocity));
  out.line("      emission_ramp: {}  # s", text(porous.emission_ramp));
  out.line("      diffusivity: {}  # m²/s", text(porous.diffusivity));
  out.line("      diffusion: {}", porous.diffusion == DiffusionLaw::linear ? "linear" : "degenerate");
  out.line("      capillary_height: {}  # m", text(porous.capillary_height));
  out.line("      adhesion: {}  # N/m", text(porous.adhesion));
  out.line("      contact_wicking: {}", porous.contact_wicking);
}

void write_cloth(Writer& out, const ClothScene& cloth) {
  out.line("  - name: {}", quoted(cloth.name));
  if (cloth.grid) {
    out.line("    mesh: {{grid: {{size: {}, nodes: {}}}}}", text(cloth.grid->size), text(cloth.grid->nodes));
  } else {
    out.line("    mesh: {{file: {}, scale: {}}}", quoted(cloth.file), text(cloth.scale));
  }
  out.line("    place: {{position: {}, rotate: {{axis: {}, degrees: {}}}}}", text(cloth.position),
           text(cloth.rotate_axis), text(cloth.rotate_degrees));
  out.line("    areal_density: {}  # kg/m²", text(cloth.areal_density));
  out.line("    thickness: {}  # m", text(cloth.thickness));
  out.line("    stretch: {}  # N/m", text(cloth.stretch));
  out.line("    bend: {}  # N·m", text(cloth.bend));
  out.line("    damping: {}  # 1/s", text(cloth.damping));
  out.line("    strain_damping: {}  # s", text(cloth.strain_damping));
  out.line("    friction: {}", text(cloth.friction));
  if (cloth.friction_wet) out.line("    friction_wet: {}", text(*cloth.friction_wet));
  if (cloth.damping_wet) out.line("    damping_wet: {}  # 1/s", text(*cloth.damping_wet));
  out.line("    strain_limit: {}", text(cloth.strain_limit));
  out.line("    adhesion: {}  # N/m", text(cloth.adhesion));
  if (cloth.sample_spacing) out.line("    sample_spacing: {}  # m", text(*cloth.sample_spacing));
  if (!cloth.pins.empty()) out.line("    pin:");
  for (const PinScene& pin : cloth.pins) write_pin(out, pin);
  out.line("    self_collision: {}", cloth.self_collision);
  out.line("    dynamics: {}", cloth.dynamics);
  write_saturation(out, "initial_saturation", cloth.initial_saturation);
  write_saturation(out, "hold_saturation", cloth.hold_saturation);
  if (cloth.porous.present) write_porous(out, cloth.porous);
}

/// Only of a scene that can have them.
void write_processes(Writer& out, const Scene& scene) {
  bool porous = false;
  for (const ClothScene& cloth : scene.cloths) porous = porous || cloth.porous.present;
  if (!porous) return;
  const auto word = [](bool on) { return on ? "on" : "off"; };
  const ProcessScene& p = scene.processes;
  out.line("processes: {{direction: {}, saturation_control: {}, absorption: {}, emission: {}, diffusion: {}}}",
           word(p.direction), word(p.saturation_control), word(p.absorption), word(p.emission), word(p.diffusion));
}

std::string motion(const BodyScene& body) {
  std::string all = fmt::format("velocity: {}, spin: {{axis: {}, degrees_per_second: {}}}", text(body.velocity),
                                text(body.spin.axis), text(body.spin.degrees_per_second));
  all += fmt::format(", dynamic: {}", body.dynamic);
  if (body.dynamic) all += fmt::format(", density: {}", text(body.density));
  all += fmt::format(", adhesion: {}", text(body.adhesion));
  return all;
}

void write_body(Writer& out, const BodyScene& body) {
  switch (body.kind) {
    case BodyScene::Kind::box:
      return out.line("  - box: {{{}, inside: {}, {}}}", corners(body.box), body.inside, motion(body));
    case BodyScene::Kind::sphere:
      return out.line("  - sphere: {{center: {}, radius: {}, {}}}", text(body.center), text(body.radius), motion(body));
    case BodyScene::Kind::plane:
      return out.line("  - plane: {{point: {}, normal: {}, {}}}", text(body.point), text(body.normal), motion(body));
    case BodyScene::Kind::mesh:
      return out.line("  - mesh: {{file: {}, scale: {}, position: {}, {}}}", quoted(body.file), text(body.scale),
                      text(body.position), motion(body));
  }
}

}  // namespace

std::string to_yaml(const Scene& scene) {
  Writer out;
  out.line("drench: {}", scene.version);
  out.line("time: {{step: {}, end: {}, mode: {}, cfl: {}}}  # s", text(scene.time.step), text(scene.time.end),
           scene.time.mode == TimeMode::fixed ? "fixed" : "cfl", text(scene.time.cfl));
  out.line("gravity: {}  # m/s²", text(scene.gravity));
  if (scene.field.present)
    out.line("field: {{center: {}, rate: {}}}  # m, 1/s", text(scene.field.center), text(scene.field.rate));
  out.line("domain: {{{}}}  # m", corners(scene.domain));
  out.line("output: {{every: {}, checkpoint_every: {}, measures: {}, surface: {}, surface_spacing: {}}}  # s",
           text(scene.output.every), text(scene.output.checkpoint_every), scene.output.measures, scene.output.surface,
           text(scene.output.surface_spacing));
  write_processes(out, scene);
  out.line("neighbors: {{sort: {}, through_cloth: {}}}", word(scene.sort), scene.through_cloth);
  if (scene.fluid.present) write_fluid(out, scene.fluid);
  if (!scene.cloths.empty()) {
    out.line("cloth_solver: {{method: {}, tolerance: {}, max_iterations: {}}}",
             scene.cloth_solver.method == ClothMethod::pd ? "pd" : "xpbd", text(scene.cloth_solver.tolerance),
             scene.cloth_solver.max_iterations);
    out.line("cloth:");
  }
  for (const ClothScene& cloth : scene.cloths) write_cloth(out, cloth);
  if (!scene.bodies.empty()) out.line("bodies:");
  for (const BodyScene& body : scene.bodies) write_body(out, body);
  return out.take();
}

}  // namespace drench
