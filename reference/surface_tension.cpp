// Stage surface_tension (src/stages/surface_tension.hpp).

#include <algorithm>
#include <cmath>

#include "rigid_bodies.hpp"

namespace drench::reference {
namespace {

using Eigen::Vector3d;

constexpr double area_share = 0.78, wall_share = 0.88;  // β_σ, β_w

struct Integrals {
  double c, k;
};

/// c_W and k_W of the scene's kernel.
Integrals integrals(const Model& m) {
  switch (m.scene.fluid.kernel) {
    case KernelKind::cubic:
      return {0.0553571428571, 0.0181070051840};
    case KernelKind::wendland:
      return {0.0520833333333, 0.0181120409795};
    case KernelKind::poly6:
      break;
  }
  return {0.0535714285714, 0.0180559193159};
}

/// A of the liquid, Pa.
double liquid_cohesion(const Model& m) {
  return (1 - area_share) * m.scene.fluid.surface_tension / (integrals(m).c * m.support);
}

/// A_b of a wall with work of adhesion w (N/m), Pa.
double wall_cohesion(const Model& m, double work) {
  const double sigma = m.scene.fluid.surface_tension;
  return sigma > 0 ? wall_share * work / sigma * liquid_cohesion(m) : work / (2 * integrals(m).c * m.support);
}

/// One sample that liquid particle i sticks to.
struct Sticky {
  double cohesion;  // A_b, Pa
  Vector3d pull;    // V_b ∇W_ib, 1/m
  Index sheet;      // of a cloth's sample; −1 of a solid's
};

std::vector<Sticky> sticky_samples(const ReferenceState& state, Index i) {
  const HostState& s = state.s;
  const Model& m = state.model;
  const Smoothing w(m);
  std::vector<Sticky> all;
  for (const Index b : state.fluid_boundary[i]) {
    const double work = m.bodies[m.boundary.body[b]].adhesion;
    const Vector3d x = vec(s.fluid_position[i]) - vec(s.boundary_position[b]);
    if (work > 0) all.push_back({wall_cohesion(m, work), s.boundary_volume[b] * w.gradient(x), -1});
  }
  for (const Index b : state.fluid_sample[i]) {
    const double work = m.material_of_sample(b).adhesion;
    if (work > 0) all.push_back({wall_cohesion(m, work), s.sample_volume[b] * w.gradient(from_behind(state, i, b)), b});
  }
  return all;
}

/// Forces of the liquid on itself, N.
void add_liquid_forces(const ReferenceState& state, Vectors& force) {
  const HostState& s = state.s;
  const Model& m = state.model;
  const double h = m.support, sigma = m.scene.fluid.surface_tension;
  const Smoothing w(m);
  Vectors normal(force.size(), Vector3d::Zero());
  for (Index i = 0; i < s.fluid_count(); ++i) {
    for (const Index j : state.fluid_fluid[i]) {
      normal[i] += h * fluid_volume(state, j) * w.gradient(vec(s.fluid_position[i]) - vec(s.fluid_position[j]));
    }
    for (const Sticky& b : sticky_samples(state, i))
      normal[i] += h * std::min(2.0, b.cohesion / liquid_cohesion(m)) * b.pull;
  }
  const double a = liquid_cohesion(m), b = area_share * sigma / (integrals(m).k * std::pow(h, 5));
  for (Index i = 0; i < s.fluid_count(); ++i) {
    for (const Index j : state.fluid_fluid[i]) {
      const Vector3d x = vec(s.fluid_position[i]) - vec(s.fluid_position[j]);
      const double q = x.norm() / h;
      const Vector3d area = (1 - q * q) / (h * h) * (normal[i] - normal[j]).dot(x) * x;
      force[i] += fluid_volume(state, i) * fluid_volume(state, j) * (a * w.gradient(x) - b * area);
    }
  }
}

}  // namespace

void surface_tension(ReferenceState& state, const StepInfo& info, StepReport&) {
  HostState& s = state.s;
  const Model& m = state.model;
  Vectors force(s.fluid_position.size(), Vector3d::Zero());
  Vectors sample_force(s.sample_volume.size(), Vector3d::Zero());
  if (m.scene.fluid.surface_tension > 0) add_liquid_forces(state, force);
  for (Index i = 0; i < s.fluid_count(); ++i) {
    const double volume = fluid_volume(state, i);
    for (const Sticky& b : sticky_samples(state, i)) {
      const Vector3d f = volume * b.cohesion * b.pull;
      force[i] += f;
      if (b.sheet >= 0) sample_force[b.sheet] -= f;
    }
  }
  Vectors change(s.fluid_position.size(), Vector3d::Zero());
  for (Index i = 0; i < s.fluid_count(); ++i) {
    const double mass = fluid_mass(state, i);
    if (mass > 0) change[i] = info.dt / mass * force[i];
    if (!state.wall_gain.empty()) change[i] = state.wall_gain[i] * change[i];
    s.fluid_velocity[i] = arr(vec(s.fluid_velocity[i]) + change[i]);
  }
  push_bodies_back(state, change);
  const Vectors node_force = spread_to_nodes(state, sample_force);
  for (Index n = 0; n < s.node_count(); ++n) {
    s.node_velocity[n] = arr(vec(s.node_velocity[n]) + info.dt * inverse_node_mass(state, n) * node_force[n]);
    if (m.mesh.is_fixed(n)) s.node_pin_force[n] = arr(vec(s.node_pin_force[n]) - node_force[n]);
  }
}

}  // namespace drench::reference
