#include "pipeline/failure.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "pipeline/stage_list.hpp"
#include "state/driven_speed.hpp"
#include "state/nozzle.hpp"

namespace drench {
namespace {

double norm(const Vec3& v) { return std::hypot(v[0], v[1], v[2]); }

double largest(const Vec3& v) { return std::max({v[0], v[1], v[2]}); }

}  // namespace

double fastest_prescribed(const Model& m) {
  double fastest = std::max(m.fastest_before, driven_speed(m));
#define DRENCH_FASTEST(name, speed) \
  if (m.scene.name.present) fastest = std::max(fastest, speed);
  DRENCH_FORCES(DRENCH_FASTEST)
#undef DRENCH_FASTEST
  for (const BlockScene& block : m.scene.fluid.blocks) fastest = std::max(fastest, norm(block.velocity));
  for (const Jet& jet : m.jets) fastest = std::max(fastest, fastest_leaving(jet));
  return fastest;
}

std::string SomeParticles::names() const {
  const auto named = std::min(count, static_cast<std::int64_t>(lowest.size()));
  return fmt::format("{}{}", fmt::join(lowest.begin(), lowest.begin() + named, " "), count > named ? " …" : "");
}

RunFailure::RunFailure(FailureKind of_kind, Stage in_stage, const StepInfo& at, const StepReport& so_far,
                       const std::string& what, double passed)
    : std::runtime_error(what), kind(of_kind), stage(in_stage), info(at), report(so_far), limit(passed) {}

Limits::Limits(const Model& m, double liquid)
    : prescribed(fastest_prescribed(m)), gravity(norm(m.scene.gravity)), mass(liquid) {
  const Box& domain = m.scene.domain;
  const double diagonal =
      norm({domain.max[0] - domain.min[0], domain.max[1] - domain.min[1], domain.max[2] - domain.min[2]});
  longest_fall = std::sqrt(2 * gravity * diagonal);
  scale = prescribed + (m.scene.field.present ? largest(m.scene.field.rate) * diagonal : 0.0);
  if (m.has_fluid()) {
    double tension = m.scene.fluid.surface_tension;  // N/m
    for (const Body& body : m.bodies) tension = std::max(tension, body.adhesion);
    m.for_materials([&](const ClothMaterial& cloth) { tension = std::max(tension, cloth.adhesion); });
    scale += std::sqrt(2 * tension / (m.rest_density * m.spacing));
    particle = m.spacing / m.scene.time.step;
  }
  double longest = 0;  // m
  for (std::size_t e = 0; e < m.mesh.edge_length.size(); ++e) {
    const double length = m.mesh.edge_length[e];
    longest = std::max(longest, length);
    shortest = std::max(shortest, 1 / length);
    if (m.has_membrane() && m.mesh.edge_stiffness[e] == 0) continue;
    softest = std::max(softest, 1 / (length * std::sqrt(m.mesh.edge_stiffness[e])));
  }
  for (const Membrane<double>& t : m.mesh.membrane)
    if (t.warp > 0)
      softest = std::max(softest,
                         (1 / std::sqrt(t.warp) + 1 / std::sqrt(t.weft) + 1 / std::sqrt(t.shear)) / std::sqrt(t.wet));
  edge = longest / m.scene.time.step;
  for (const double solid : m.mesh.solid_mass) mass += solid;
  for (const Body& body : m.bodies) mass += body.mass;
  for (const Jet& jet : m.jets)
    supply += m.rest_density * jet.area * (jet.mouth ? jet.speed.largest() : jet.scene.velocity.largest());
  if (m.has_reservoirs() || m.has_baked_liquid()) mass = std::numeric_limits<double>::infinity();
}

double Limits::fluid_speed(double time) const {
  return 10 * (scale + std::min(gravity * time, longest_fall) + particle);
}

double Limits::cloth_speed(double time) const { return 10 * (scale + gravity * time + edge); }

double Limits::cloth_stretch(double time) const {
  if (!(softest > 0) || std::isinf(softest) || std::isinf(mass)) return std::numeric_limits<double>::infinity();
  const double speed = scale + gravity * time;
  return 10 * (1 + speed * std::sqrt(mass + supply * time) * softest + 2 * prescribed * time * shortest);
}

}  // namespace drench
