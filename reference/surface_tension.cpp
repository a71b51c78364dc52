// Stage surface_tension (src/stages/surface_tension.hpp).

#include <cmath>
#include <numbers>

#include "common.hpp"

namespace drench::reference {
namespace {

using Eigen::Vector3d;
using std::numbers::pi;

/// Akinci, Akinci & Teschner 2013, Eq. 7: a(r), 1/m³.
double adhesion_kernel(double r, double h) {
  if (r <= h / 2 || r >= h) return 0;
  return 0.007 / std::pow(h, 3.25) * std::pow(-4 * r * r / h + 6 * r - 2 * h, 0.25);
}

/// D, N/m³, for work of adhesion w (N/m).
double adhesion_strength(const Model& m, double work) {
  const double d = m.spacing, h = m.support;
  const double m0 = std::pow(4.0, -1.25) * std::tgamma(0.5) * std::tgamma(1.25) / std::tgamma(1.75);
  const double m2 = m0 * 65 / 112, m3 = m0 * 207 / 448;
  const double j = h * m3 / 3 - d * m2 / 4 + d * d * d * m0 / (48 * h * h);
  return work / (0.007 * 2 * pi * j * d);
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
  }
  double c = 0, k = 0;
  switch (m.scene.fluid.kernel) {
    case KernelKind::cubic:
      c = 0.0553571428571;
      k = 0.0181070051840;
      break;
    case KernelKind::wendland:
      c = 0.0520833333333;
      k = 0.0181120409795;
      break;
    case KernelKind::poly6:
      c = 0.0535714285714;
      k = 0.0180559193159;
      break;
  }
  constexpr double share = 0.78;
  const double a = (1 - share) * sigma / (c * h), b = share * sigma / (k * std::pow(h, 5));
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
    const auto pull = [&](double strength, double sample_volume, const Vector3d& x) -> Vector3d {
      return -strength * volume * sample_volume * adhesion_kernel(x.norm(), m.support) * x.normalized();
    };
    for (const Index b : state.fluid_boundary[i]) {
      const double work = m.bodies[m.boundary.body[b]].adhesion;
      if (work == 0) continue;
      const double strength = adhesion_strength(m, work);
      force[i] += pull(strength, s.boundary_volume[b], vec(s.fluid_position[i]) - vec(s.boundary_position[b]));
    }
    for (const Index b : state.fluid_sample[i]) {
      const double work = m.cloths[m.samples.cloth[b]].adhesion;
      if (work == 0) continue;
      const Vector3d f = pull(adhesion_strength(m, work), s.sample_volume[b], from_behind(state, i, b));
      force[i] += f;
      sample_force[b] -= f;
    }
  }
  for (Index i = 0; i < s.fluid_count(); ++i) {
    const double mass = fluid_mass(state, i);
    if (mass > 0) s.fluid_velocity[i] = arr(vec(s.fluid_velocity[i]) + info.dt / mass * force[i]);
  }
  const Vectors node_force = spread_to_nodes(state, sample_force);
  for (Index n = 0; n < s.node_count(); ++n) {
    s.node_velocity[n] = arr(vec(s.node_velocity[n]) + info.dt * inverse_node_mass(state, n) * node_force[n]);
    if (m.mesh.pinned[n]) s.node_pin_force[n] = arr(vec(s.node_pin_force[n]) - node_force[n]);
  }
}

}  // namespace drench::reference
