#include "setup/build.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <numeric>

#include "base/eigen_vec.hpp"
#include "setup/air.hpp"
#include "setup/baked_liquid.hpp"
#include "setup/body_fields.hpp"
#include "setup/body_geometry.hpp"
#include "setup/body_sampling.hpp"
#include "setup/cloth_boundary.hpp"
#include "setup/cloth_material.hpp"
#include "setup/cloth_mesh.hpp"
#include "setup/cloth_regions.hpp"
#include "setup/cloth_sampling.hpp"
#include "setup/deforming_body.hpp"
#include "setup/distance_field.hpp"
#include "setup/emitters.hpp"
#include "setup/fabric_pairs.hpp"
#include "setup/file_place.hpp"
#include "setup/fluid_sampling.hpp"
#include "setup/memory_estimate.hpp"
#include "setup/mesh_guess.hpp"
#include "setup/pieces.hpp"
#include "setup/point_grid.hpp"
#include "setup/rest_plane.hpp"
#include "setup/self_intersection.hpp"
#include "setup/smoothing_kernel.hpp"
#include "setup/solid_mesh.hpp"
#include "setup/solute.hpp"
#include "setup/surface_mesh.hpp"
#include "setup/wall_planes.hpp"
#include "setup/warnings.hpp"
#include "state/fastest.hpp"
#include "state/needed_fields.hpp"

namespace drench {
namespace {

void set_numbers(Model& m) {
  const FluidScene& fluid = m.scene.fluid;
  m.spacing = fluid.spacing;
  // Without liquid particles nothing fixes d, and the scene's default knows nothing of the cloth's size. Its samples
  // should be about as fine as its mesh: then wicking costs and resolves what the mesh does.
  if (!m.has_fluid() && m.has_cloth()) m.spacing = mean_edge_length(m);
  m.support = fluid.support * m.spacing;
  m.layer_share = layer_share(m.spacing, m.support, fluid.kernel);
  if (fluid.present) m.relaxation = jacobi_relaxation(fluid.kernel, fluid.support);
  m.rest_density = fluid.density;
  m.particle_mass = m.rest_density * m.spacing * m.spacing * m.spacing;
  m.quantum = m.particle_mass / static_cast<double>(quanta_per_particle);
  m.min_quanta = std::llround(0.05 * static_cast<double>(quanta_per_particle));
  m.max_quanta = quanta_per_particle;
  set_absorption(m);
  set_permeation(m);
  set_films(m);
  set_node_materials(m);
  if (m.scene.air.present) m.evaporation_flux = evaporation_flux(m.scene);
  if (m.scene.air.cooling && m.has_drying()) {
    const WetBulb wet = wet_bulb(m.scene);
    m.cooling = m.evaporation_flux / wet.flux - 1;
    m.wet_bulb = wet.temperature;
  }
  set_concentration_unit(m);
}

/// The domain and a support radius around it: samples beyond cannot touch a particle.
Box wetted_region(const Model& m) {
  Box region = m.scene.domain;
  for (int a = 0; a < 3; ++a) {
    region.min[a] -= m.support;
    region.max[a] += m.support;
  }
  return region;
}

/// m
double farthest_corner(const Box& box, const Vec3& x) {
  double square = 0;
  for (int a = 0; a < 3; ++a) square += std::pow(std::max(x[a] - box.min[a], box.max[a] - x[a]), 2);
  return std::sqrt(square);
}

SetupSize grid_size(const Scene& scene) {
  SetupSize size;
  for (const ClothScene& c : scene.cloths) {
    if (c.grid) size.nodes += static_cast<double>(c.grid->nodes[0]) * c.grid->nodes[1];
  }
  return size;
}

SetupSize expected_size(const Model& m, const std::vector<SourceFile>& files) {
  SetupSize size = kinds_of(m);
  size.nodes = m.mesh.nodes();
  if (m.has_fluid() || m.has_porous()) {
    size.samples = expected_cloth_samples(m);
    size.area = cloth_area(m) / (m.spacing * m.spacing);
  }
  if (!m.has_fluid()) return size;
  size.fluid = expected_block_particles(m.scene.fluid, files);
  const Box region = wetted_region(m);
  for (std::size_t b = 0; b < m.bodies.size(); ++b) {
    double samples = 0;
    for (int layer = 0; layer < body_layers(m.bodies[b], m.spacing, m.support); ++layer)
      samples += expected_body_samples(m.bodies[b], m.spacing, m.scene.fluid.wall_pressure,
                                       sampled_region(m.bodies[b], region, m.scene.time.end, layer), layer);
    if (samples > max_body_samples) {
      throw SetupError(
          fmt::format("{}: its surface needs more than {:.0f} boundary particles at spacing {} m; use a smaller domain "
                      "or body, or a larger spacing",
                      body_label(m.bodies[b].name, b), max_body_samples, m.spacing),
          fmt::format("bodies.{}", b));
    }
    size.boundary += samples;
  }
  return size;
}

void sample_bodies(Setup& setup) {
  Model& m = setup.model;
  const Box region = wetted_region(m);
  const WallPressure walls = m.scene.fluid.wall_pressure;
  for (std::size_t b = 0; b < m.bodies.size(); ++b) {
    Body& body = m.bodies[b];
    std::vector<Vec3> samples;
    std::vector<double> volumes;
    if (body.deforms()) {
      samples = bind_samples(body, m.spacing);
      for (const double volume : akinci_volumes(samples, m.support, m.scene.fluid.kernel))
        volumes.push_back(volume * m.layer_share);
      if (m.has_slipping_body()) add_wall_planes(body, m.spacing, walls, region, 0, samples, m.boundary);
    }
    for (int layer = 0; layer < body_layers(body, m.spacing, m.support) && !body.deforms(); ++layer) {
      const Box within = sampled_region(body, region, m.scene.time.end, layer);
      const std::vector<Vec3> more = sample_body(body, m.spacing, walls, within, layer);
      if (m.has_slipping_body()) add_wall_planes(body, m.spacing, walls, within, layer, more, m.boundary);
      // Each layer counts for one layer of liquid, and only its own samples share it.
      for (const double volume : akinci_volumes(more, m.support, m.scene.fluid.kernel))
        volumes.push_back(volume * m.layer_share);
      samples.insert(samples.end(), more.begin(), more.end());
    }
    body.first_sample = m.boundary.count();
    body.sample_count = static_cast<Index>(samples.size());
    if (samples.empty() && !body.moves())
      setup.warnings.push_back(
          fmt::format("{}: it is outside the domain, where no liquid reaches it; enlarge the domain or move the body",
                      body_label(body.name, b)));
    m.boundary.position.insert(m.boundary.position.end(), samples.begin(), samples.end());
    m.boundary.body.insert(m.boundary.body.end(), samples.size(), static_cast<Index>(b));
    setup.state.boundary_volume.insert(setup.state.boundary_volume.end(), volumes.begin(), volumes.end());
    if (body.deforms())
      for (const Vec3& v : first_velocities(body)) setup.state.boundary_velocity.push_back(v);
    else
      for (const Vec3& x : samples) setup.state.boundary_velocity.push_back(body_velocity(body, x));
  }
  setup.state.boundary_position = m.boundary.position;
}

/// Warns of nodes that start inside a body, and sets how fast they are brought out.
void settle_nodes_in_solids(Setup& setup) {
  constexpr double least_release = 0.1;  // of the thickness, per longest step
  Model& m = setup.model;
  for (std::size_t k = 0; k < m.cloths.size(); ++k) {
    ClothMaterial& c = m.cloths[k];
    std::size_t inside = 0;
    double deepest = 0;
    for (auto n = static_cast<std::size_t>(c.first_node); n < static_cast<std::size_t>(c.first_node + c.node_count);
         ++n) {
      if (m.mesh.pinned[n]) continue;
      for (const Body& body : m.bodies) {
        Vec3 normal;
        const double distance = signed_distance(body, m.mesh.rest_position[n], normal);
        if (distance >= -rounding_of(body)) continue;
        deepest = std::max(deepest, -distance);
        ++inside;
        break;
      }
    }
    setup.deepest_inside = std::max(setup.deepest_inside, deepest);
    const int steps = m.scene.cloths[k].settle;
    c.release = std::max(least_release * c.thickness, (deepest + c.thickness) / steps) / m.scene.time.step;
    for (ClothMaterial& patch : m.patches)
      if (patch.of_cloth == static_cast<Index>(k)) patch.release = c.release;
    if (inside > 0) {
      setup.warnings.push_back(
          fmt::format("{}: {} start{} inside a solid body, up to {:.2g} m deep; moved out over {:.2g} s "
                      "(cloth.{}.settle times time.step)",
                      cloth_label(c.name), inside == 1 ? "1 free node" : fmt::format("{} free nodes", inside),
                      inside == 1 ? "s" : "", deepest, steps * m.scene.time.step, k));
    }
  }
}

/// Only a mesh with an inside can keep cloth out of it.
void refuse_cloth_on_thin_walls(const Model& m) {
  for (std::size_t b = 0; b < m.bodies.size(); ++b)
    if (m.has_moving_cloth() && m.bodies[b].kind == BodyScene::Kind::mesh && m.bodies[b].field.spacing == 0)
      blaming(fmt::format("bodies.{}.mesh.{}", b, m.scene.bodies[b].inside ? "inside" : "file"),
              [&] { refuse_thin_wall(m.bodies[b], m.scene.bodies[b], body_label(m.bodies[b].name, b)); });
}

void init_nodes(const Model& m, HostState& s) {
  const std::size_t nodes = m.mesh.rest_position.size();
  s.node_position = m.mesh.rest_position;
  s.node_velocity.assign(nodes, Vec3{0, 0, 0});
  for (std::size_t k = 0; k < m.cloths.size(); ++k)
    for (Index n = m.cloths[k].first_node; n < m.cloths[k].first_node + m.cloths[k].node_count; ++n)
      if (!m.mesh.pinned[at(n)]) s.node_velocity[at(n)] = m.scene.cloths[k].velocity;
  s.node_liquid.assign(nodes, 0);
  s.node_buffered.assign(nodes, 0);
  s.node_contact_force.assign(nodes, Vec3{0, 0, 0});
  s.node_friction_force.assign(nodes, Vec3{0, 0, 0});
  s.node_pin_force.assign(nodes, Vec3{0, 0, 0});
  if (m.has_solute()) s.node_solute.assign(nodes, 0);
  if (m.has_squeezing()) s.node_contact_pressure.assign(nodes, 0.0);
  if (m.has_hysteresis()) {
    s.node_scanning.assign(nodes, 0.0);
    s.node_extreme.assign(nodes, 0.0);
  }
  s.sample_volume.assign(m.samples.rest_position.size(), 0);
  if (m.has_fluid()) s.sample_volume = akinci_volumes(m.samples.rest_position, m.support, m.scene.fluid.kernel);
  for (double& volume : s.sample_volume) volume *= m.layer_share;
  s.sample_flow_direction.assign(s.sample_volume.size(), Vec3{0, 0, 0});
  if (m.has_permeation()) s.sample_flux.assign(s.sample_volume.size(), 0.0);
  if (!m.counts_faces()) return;
  for (auto* account : {&s.sample_taken_front, &s.sample_taken_back, &s.sample_given_front, &s.sample_given_back})
    account->assign(s.sample_volume.size(), 0);
}

/// A block starts as a lattice; one that counts as compressed bursts in the first steps.
void warn_of_dense_lattice(Setup& setup) {
  const FluidScene& fluid = setup.model.scene.fluid;
  const double density = lattice_density(fluid.kernel, fluid.support);
  if (fluid.blocks.empty() || fluid.is_baked() || density <= 1.02) return;
  double enough = fluid.support;
  while (lattice_density(fluid.kernel, enough) > 1.02) enough += 0.1;
  setup.warnings.push_back(
      fmt::format("fluid: with this kernel and support a block starts at {:.3f} of the rest density and bursts; "
                  "use a support of {:.1f}",
                  density, enough));
}

/// A fixed step that capillary waves outrun makes the liquid burst.
void warn_of_capillary_step(Setup& setup) {
  const TimeScene& time = setup.model.scene.time;
  const double longest = setup.model.capillary_step();
  if (time.mode != TimeMode::fixed || time.step <= longest) return;
  setup.warnings.push_back(
      fmt::format("time.step {:.2g} s is longer than surface tension or adhesion allows at this spacing: use at most "
                  "{:.2g} s, or time.mode cfl",
                  time.step, longest));
}

void init_fluid(Setup& setup, std::vector<SourceFile> files) {
  HostState& s = setup.state;
  s.jet_particles.assign(setup.model.jets.size(), 0);
  if (setup.model.has_baked_liquid()) {
    BakedLiquid(setup.model).start(s, setup.warnings);
    setup.model.fastest_before = fastest_of(s.fluid_velocity);
    return;
  }
  BlockParticles particles =
      blaming("fluid.sources", [&] { return fill_blocks(setup.model, std::move(files), setup.warnings); });
  const std::size_t count = particles.position.size();
  resize_liquid(s, setup.model, count);
  s.fluid_position = std::move(particles.position);
  setup.model.fastest_before = fastest_of(particles.velocity);
  s.fluid_velocity = std::move(particles.velocity);
  s.fluid_mass = std::move(particles.mass);
  std::iota(s.fluid_id.begin(), s.fluid_id.end(), std::int64_t{0});
  s.next_id = static_cast<std::int64_t>(count);
  dissolve_in_blocks(setup.model, particles.block, s);
}

/// The ledger adds quanta in 64 bits: far more liquid than fits would wrap around.
void check_ledger_range(const Setup& setup) {
  const std::vector<Quanta>& mass = setup.state.fluid_mass;
  double quanta = std::accumulate(mass.begin(), mass.end(), 0.0);
  for (const double capacity : setup.model.samples.node_capacity) quanta += 2 * capacity / setup.model.quantum;
  if (!(quanta < 0x1p62)) {
    throw SetupError(
        "the cloth can hold more liquid than 2^30 particles, too much to count exactly: use a larger spacing",
        "fluid.spacing");
  }
}

}  // namespace

namespace {

/// Pins that follow a body turn about its centre.
void follow_bodies(Model& m) {
  for (std::size_t n = 0; n < m.mesh.pin_motion.size(); ++n) {
    if (m.mesh.pin_motion[n] < 0) continue;
    PinMotion& motion = m.pin_motions[static_cast<std::size_t>(m.mesh.pin_motion[n])];
    if (motion.body < 0) continue;
    const Body& body = m.bodies[static_cast<std::size_t>(motion.body)];
    if (body.deforms())
      throw SetupError(
          fmt::format("pins cannot follow body '{}', because its shape changes; allowed: pins with sequence",
                      body.name),
          fmt::format("bodies.{}", motion.body));
    motion.center = body.center;
    motion.reach = std::max(motion.reach, (to_eigen(m.mesh.rest_position[n]) - to_eigen(motion.center)).norm());
  }
}

void make_joints(Model& m) {
  const auto numbered = [&](const std::string& name) {
    for (std::size_t b = 0; b < m.bodies.size(); ++b)
      if (m.scene.bodies[b].name == name) return static_cast<Index>(b);
    return Index{-1};
  };
  constexpr double radian = std::numbers::pi / 180;
  for (const JointScene& scene : m.scene.joints) {
    Joint joint{.body = numbered(scene.body),
                .other = scene.to.empty() ? -1 : numbered(scene.to),
                .point = scene.point,
                .axis = to_vec3(to_eigen(scene.axis).normalized())};
    if (joint.other >= 0 && m.bodies[static_cast<std::size_t>(joint.other)].deforms())
      throw SetupError(fmt::format("a hinge cannot be fixed to body '{}', because its shape changes; allowed: a body "
                                   "that keeps its shape",
                                   scene.to),
                       fmt::format("joints.{}.hinge.to", m.joints.size()));
    joint.limited = scene.limits != JointScene{}.limits;
    joint.low = radian * scene.limits[0];
    joint.high = radian * scene.limits[1];
    if (scene.motor.present) {
      joint.speed = scene.motor.degrees_per_second.scaled(radian);
      joint.torque = scene.motor.torque;
    }
    m.joints.push_back(joint);
  }
}

void make_bodies(Setup& setup, SetupLines& lines) {
  Model& m = setup.model;
  const Scene& scene = m.scene;
  for (std::size_t b = 0; b < scene.bodies.size(); ++b) {
    const std::string label = body_label(scene.bodies[b].name, b);
    const MeshUse use = m.has_moving_cloth() ? MeshUse::solid : MeshUse::solid_or_vessel;
    m.bodies.push_back(blaming(fmt::format("bodies.{}", b),
                               [&] { return make_body(scene.bodies[b], scene.path, label, &setup.warnings, use); }));
    const BodyScene& body = scene.bodies[b];
    for (const ProbeScene& probe : scene.output.probes)
      if (probe.kind == ProbeScene::Kind::body && probe.of == body.name) m.bodies[b].probed = true;
    if (body.kind != BodyScene::Kind::mesh) continue;
    if (std::string hint = unit_hint(m.bodies[b].mesh_points, body.unit, body.scale, label); !hint.empty())
      lines.hints.push_back(std::move(hint));
  }
  for (Body& body : m.bodies)
    if (body.kind == BodyScene::Kind::plane) {
      body.reach = farthest_corner(scene.domain, body.point);
      body.slides = body.moves();
      if (body.slides) body.lattice = plane_lattice(body, m.spacing);
      for (std::size_t a = 0; a < 3; ++a) body.middle[a] = 0.5 * (scene.domain.min[a] + scene.domain.max[a]);
    }
  for (std::size_t b = 0; b < m.bodies.size(); ++b)
    for (std::string& line : deformation_warnings(m.bodies[b], body_label(m.bodies[b].name, b)))
      setup.warnings.push_back(std::move(line));
  start_bodies(m, setup.state);
  follow_bodies(m);
  make_joints(m);
}

/// Everything after the meshes.
void fill(Setup& setup, SetupLines& lines, const MemoryBudget& budget, FilledBodies* filled) {
  Model& m = setup.model;
  lay_body_fields(m, wetted_region(m), setup.warnings);
  refuse_cloth_on_thin_walls(m);
  std::vector<std::string> hints;
  std::vector<SourceFile> files =
      blaming("fluid.sources", [&] { return read_source_files(m.scene, setup.warnings, hints); });
  for (const std::string& hint : hints) {
    setup.warnings.push_back(hint);
    lines.hints.push_back(hint);
  }
  refuse_too_large(expected_size(m, files), budget);
  fill_body_fields(m, filled);
  if (m.has_fluid() || m.has_porous()) build_samples(m);
  if (m.has_fluid() && !m.scene.through_cloth) find_boundary_edges(m);
  if (m.has_diffusion()) build_fabric_pairs(m);
  init_nodes(m, setup.state);
  check_ledger_range(setup);
  fill_cloths(m, setup.state, setup.warnings);
  warn_of_thin_solute(m, setup.warnings);
  refuse_self_intersections(m);
  settle_nodes_in_solids(setup);
  if (m.has_fluid()) {
    m.jets = blaming("fluid.sources", [&] { return make_jets(m, setup.warnings); });
    sample_bodies(setup);
    warn_of_dense_lattice(setup);
    warn_of_capillary_step(setup);
    init_fluid(setup, std::move(files));
    check_ledger_range(setup);
  }
  list_pieces(m, setup.notes, setup.warnings);
  for (std::string& line : plan_warnings(m, setup.state, budget.real_bytes)) setup.warnings.push_back(std::move(line));
}

}  // namespace

Setup build(const Scene& scene, const MemoryBudget& budget, FilledBodies* filled) {
  Setup setup;
  setup.model.scene = scene;
  refuse_too_large(grid_size(scene), budget);
  SetupLines lines;
  build_cloths(scene, setup.model, lines);
  lay_rest_planes(setup.model);
  set_numbers(setup.model);
  setup.warnings = std::move(lines.warnings);
  setup.notes = std::move(lines.notes);
  make_bodies(setup, lines);
  setup.warnings.insert(setup.warnings.end(), lines.hints.begin(), lines.hints.end());
  try {
    fill(setup, lines, budget, filled);
  } catch (const SetupError& e) {
    if (lines.hints.empty()) throw;
    // A mesh in another unit is the likely cause.
    throw SetupError(fmt::format("{} ({})", fmt::join(lines.hints, "; "), e.what()), e.key);
  }
  return setup;
}

}  // namespace drench
