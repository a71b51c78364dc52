#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <string>

#include "app/commands.hpp"
#include "app/set_up.hpp"
#include "pipeline/pipeline.hpp"
#include "pipeline/runtime.hpp"
#include "scene/build.hpp"
#include "scene/load.hpp"

namespace drench {
namespace {

double dot(const Vec3& a, const Vec3& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }
double length(const Vec3& v) { return std::sqrt(dot(v, v)); }

/// Height (along `up`) of the lowest corner of a box.
double lowest(const Box& box, const Vec3& up) {
  double height = 0;
  for (std::size_t k = 0; k < 3; ++k) height += up[k] * (up[k] > 0 ? box.min[k] : box.max[k]);
  return height;
}

/// Height of the highest floor that lies under all the liquid: the domain, a container or a plane.
double floor_height(const Model& model, const Vec3& up, double lowest_liquid) {
  double floor = lowest(model.scene.domain, up);
  for (const Body& body : model.bodies) {
    double height = floor;
    if (body.kind == BodyScene::Kind::box && body.inside) height = lowest(body.box, up);
    if (body.kind == BodyScene::Kind::plane && dot(body.normal, up) > 0.999) height = dot(body.point, up);
    if (height <= lowest_liquid) floor = std::max(floor, height);
  }
  return floor;
}

/// The fastest that liquid can get by its start and free fall down to the floor or until the end, or that a body is, m/s.
double largest_speed(const Model& model, const HostState& state) {
  const double g = length(model.scene.gravity);
  const Vec3 up = g > 0 ? Vec3{-model.scene.gravity[0] / g, -model.scene.gravity[1] / g, -model.scene.gravity[2] / g}
                        : Vec3{0, 1, 0};
  double speed = 0, top = -INFINITY, bottom = INFINITY;
  const auto include = [&](const Vec3& position, const Vec3& velocity) {
    speed = std::max(speed, length(velocity));
    top = std::max(top, dot(position, up));
    bottom = std::min(bottom, dot(position, up));
  };
  for (std::size_t i = 0; i < state.fluid_position.size(); ++i)
    include(state.fluid_position[i], state.fluid_velocity[i]);
  for (const Jet& jet : model.jets) include(jet.scene.center, jet.scene.velocity);
  for (const Vec3& x : state.node_position)
    if (model.has_emission()) include(x, {0, 0, 0});  // water drips off the cloth
  double driven = 0;                                  // by bodies that move
  for (const Body& body : model.bodies)
    driven = std::max(driven, length(body.velocity) + std::abs(body.spin_rate) * body.reach);
  if (!std::isfinite(top)) return driven;
  const double drop = std::max(0.0, top - floor_height(model, up, bottom));
  return std::max(driven, std::min(speed + g * model.scene.time.end, std::sqrt(speed * speed + 2 * g * drop)));
}

/// Sub-steps that one cloth asks for in stage diffusion (src/stages/diffusion.hpp, law 3) in its rest shape.
double diffusion_substeps(const Model& model, const ClothMaterial& cloth, double dt) {
  const FabricPairs& fabric = model.fabric;
  const double load = model.rest_density * (1 - cloth.solid_fraction) * cloth.thickness;
  const double most = cloth.diffusion == DiffusionLaw::degenerate ? cloth.max_saturation : 1;
  double fastest = 0;
  for (Index n = cloth.first_node; n < cloth.first_node + cloth.node_count; ++n) {
    const auto at = static_cast<std::size_t>(n);
    double sum = 0;
    for (Index k = fabric.of_node.start[at]; k < fabric.of_node.start[at + 1]; ++k)
      sum += fabric.weight[static_cast<std::size_t>(fabric.of_node.item[static_cast<std::size_t>(k)] / 2)];
    if (model.samples.node_capacity[at] > 0)
      fastest = std::max(fastest, most * load * cloth.diffusivity * sum / model.samples.node_capacity[at]);
  }
  return std::max(1.0, std::ceil(dt * fastest / 0.5));
}

/// Stages of the viscosity a step (src/stages/forces.hpp) in full neighbourhoods: Σ V |∇W| r = 3 there; C_i grows
/// to about twice that beside solids, and light cloth can need more.
double viscous_stages(const Model& model, double dt) {
  const double bound = 3 * 30 * model.scene.fluid.viscosity / (model.support * model.support);
  return std::ceil(std::sqrt(0.25 + 2 * dt * bound) - 0.5);
}

/// Stages of the spins a step (src/stages/micropolar.hpp) in full neighbourhoods: k = 3 there, and g = 6/h at most.
double spin_stages(const Model& model, double dt) {
  const MicropolarScene& spin = model.scene.fluid.micropolar;
  const double h = model.support, inertia = spin.inertia * model.spacing * model.spacing;
  const double bound = spin.transfer / 2 * (144 / (h * h) + 9 / inertia) + 2 * 6 * spin.viscosity / (h * h) * 3;
  return std::ceil(std::sqrt(0.25 + dt * bound) - 0.5);
}

void print_parts(const Model& model, const HostState& state) {
  if (model.has_fluid())
    fmt::print("fluid: {} particles of {:.4g} m, {:.4g} kg, {} jets\n", state.fluid_count(), model.spacing,
               static_cast<double>(state.fluid_count()) * model.particle_mass, model.jets.size());
  for (const ClothMaterial& c : model.cloths)
    fmt::print("cloth {}: {} nodes, {} triangles, {} samples{}{}\n", c.name, c.node_count, c.triangle_count,
               c.sample_count, c.porous ? ", porous" : "", c.dynamics ? "" : ", still");
  if (model.has_cloth()) {
    const auto pinned = std::count(model.mesh.pinned.begin(), model.mesh.pinned.end(), 1);
    double capacity = 0;
    for (const double c : model.samples.capacity) capacity += c;
    fmt::print("cloth in all: {} nodes, {} pinned, {} edges, {} hinges, holds {:.4g} kg of liquid at saturation 1\n",
               model.mesh.nodes(), pinned, model.mesh.edge.size(), model.mesh.hinge.size(), capacity);
  }
  if (!model.bodies.empty())
    fmt::print("bodies: {} ({} moving, {} floating), {} boundary samples\n", model.bodies.size(),
               std::count_if(model.bodies.begin(), model.bodies.end(), [](const Body& b) { return b.moves(); }),
               std::count_if(model.bodies.begin(), model.bodies.end(), [](const Body& b) { return b.dynamic; }),
               model.boundary.count());
}

void print_memory(const Setup& setup, const MemoryBudget& budget) {
  SetupSize size = size_of(setup);
  const MemoryEstimate m = estimate_memory(size, budget.real_bytes);
  fmt::print(
      "memory: about {}: liquid {}, neighbour lists {}, cell tables {}, bodies {}, cloth {}; and {} for the set-up "
      "and a frame{}\n",
      mebibytes(m.backend()), mebibytes(m.particles), mebibytes(m.lists), mebibytes(m.cells), mebibytes(m.bodies),
      mebibytes(m.cloth), mebibytes(m.host),
      budget.device.empty() ? "" : fmt::format("; {} has {} free", budget.device, mebibytes(budget.device_free)));
  const double more = jet_particles(setup.model);
  if (more >= 1) {
    size.fluid += more;
    fmt::print("memory with {:.0f} particles from jets: about {}\n", more,
               mebibytes(estimate_memory(size, budget.real_bytes).backend()));
  }
  if (size.fluid > 0) {
    size.crowding = 1.7;
    fmt::print("memory in a splash, with up to {} times as many neighbours: about {}\n", size.crowding,
               mebibytes(estimate_memory(size, budget.real_bytes).backend()));
  }
}

}  // namespace

int check_command(const std::string& path, const std::vector<std::string>& overrides) {
  const Scene scene = load_scene(path, overrides);
  MemoryBudget budget;
  std::string no_device;
  try {
    budget = memory_budget();
  } catch (const DeviceError& e) {  // a scene can be checked without one
    no_device = e.what();
  }
  const Setup setup = build(scene, budget);
  refuse_too_large(size_of(setup), budget);  // now that lists are known to be as wide as they are
  const Model& model = setup.model;
  auto warnings = setup.warnings;
  if (!no_device.empty()) warnings.push_back(no_device);
  fmt::print("scene: {}\n", path);
  print_parts(model, setup.state);
  std::string stages;
  for (const Stage s : stages_for(model)) stages += fmt::format(" {}", name_of(s));
  fmt::print("stages:{}\n", stages);
  print_memory(setup, budget);

  double dt = scene.time.step;
  if (model.has_fluid()) {
    const double speed = largest_speed(model, setup.state);
    const double displacement = speed * dt / model.spacing;
    if (scene.time.mode == TimeMode::cfl) {
      if (speed > 0) dt = std::min(dt, scene.time.cfl * model.spacing / speed);
      dt = std::min(dt, model.capillary_step());
      fmt::print("time step: {:.4g} s, down to {:.4g} s at {:.3g} m/s (free fall)\n", scene.time.step, dt, speed);
    } else {
      fmt::print("time step: {:.4g} s; at {:.3g} m/s (free fall) {:.2g} spacings a step\n", dt, speed, displacement);
      if (displacement > 1)
        warnings.push_back(
            fmt::format("particles may move {:.2g} spacings in a step: a time.step of {:.2g} s or "
                        "time.mode cfl would be safer",
                        displacement, scene.time.cfl * model.spacing / speed));
    }
  } else {
    fmt::print("time step: {:.4g} s\n", dt);
  }
  fmt::print("steps: {}{:.0f} to {:.4g} s\n", scene.time.mode == TimeMode::cfl ? "at least " : "",
             std::ceil(scene.time.end / scene.time.step - 1e-9), scene.time.end);
  if (const double passes = model.has_fluid() ? viscous_stages(model, scene.time.step) : 0; passes > 1)
    fmt::print("viscosity: about {:.0f} passes a step\n", passes);
  if (const double passes = model.has_micropolar() ? spin_stages(model, scene.time.step) : 0; passes > 1)
    fmt::print("micropolar: about {:.0f} passes a step\n", passes);
  for (const ClothMaterial& c : model.cloths)
    if (model.has_diffusion() && c.porous && c.diffusivity > 0)
      fmt::print("diffusion in {}: sub-steps a step: about {:.0f}\n", c.name,
                 diffusion_substeps(model, c, scene.time.step));
  const double parts = scene.output.every / scene.time.step;
  if (scene.time.mode == TimeMode::fixed && parts > 0 && std::abs(parts - std::round(parts)) > 1e-6)
    warnings.push_back(
        fmt::format("output.every is {:.4g} times time.step: the step before each frame is a shorter one; "
                    "a whole number avoids that",
                    parts));
  for (const std::string& w : warnings) fmt::print("warning: {}\n", w);
  return exit_done;
}

}  // namespace drench
