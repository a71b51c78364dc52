// Stage wind of the reference; the equation is in docs/dev/add_a_force.md.

#include "stages/wind.hpp"

#include <numbers>

#include "common.hpp"

namespace drench::reference {
namespace {

using Eigen::Vector3d;

/// Eqs. 2 to 5: impulses on the nodes, kg m/s.
Vectors impulses_on_cloth(const ReferenceState& state, const Vector3d& air, double dt) {
  const HostState& s = state.s;
  const Model& m = state.model;
  const WindScene& wind = m.scene.wind;
  Vectors impulse(s.node_position.size(), Vector3d::Zero());
  for (std::size_t t = 0; t < m.mesh.triangle.size(); ++t) {
    const auto& corner = m.mesh.triangle[t];
    const auto x = [&](int c) { return vec(s.node_position[corner[c]]); };
    Vector3d w = air;
    double lightest = std::numeric_limits<double>::infinity();  // kg/m²
    for (const Index n : corner) {
      w -= vec(s.node_velocity[n]) / 3;
      lightest = std::min(lightest, m.material_of_node(n).areal_density * node_mass(state, n) / m.mesh.solid_mass[n]);
    }
    const Vector3d normal = (x(1) - x(0)).cross(x(2) - x(0));
    if (normal.norm() == 0) continue;
    const double area = normal.norm() / 2;
    const Vector3d across = w.dot(normal.normalized()) * normal.normalized(), along = w - across;
    const double rate = dt * 0.5 * wind.density * w.norm();  // kg/m²
    const auto taken = [&](double drag) { return rate * drag / (1 + rate * drag / lightest); };
    const Vector3d p = area * (taken(wind.normal_drag) * across + taken(wind.tangential_drag) * along);
    for (const Index n : corner) impulse[n] += p / 3;
  }
  return impulse;
}

/// Eq. 8: the part of a particle that the air reaches; w is the air's velocity relative to it.
double exposure(const ReferenceState& state, Index i, const Vector3d& w) {
  const Vector3d xi = vec(state.s.fluid_position[i]), upwind = -w.normalized();
  double shade = 0;
  const auto look_at = [&](const Vector3d& x) {
    if (x != xi) shade = std::max(shade, upwind.dot((x - xi).normalized()));
  };
  for (const Index j : state.fluid_fluid[i]) look_at(vec(state.s.fluid_position[j]));
  for (const Index b : state.fluid_boundary[i]) look_at(vec(state.s.boundary_position[b]));
  for (const Index b : state.fluid_sample[i]) look_at(sample_position(state, b));
  return 1 - shade;
}

/// Eqs. 6 to 8.
void drag_liquid(ReferenceState& state, const Vector3d& air, double dt) {
  HostState& s = state.s;
  const WindScene& wind = state.model.scene.wind;
  for (Index i = 0; i < s.fluid_count(); ++i) {
    const Vector3d v = vec(s.fluid_velocity[i]), w = air - v;
    const double mass = fluid_mass(state, i);
    if (!(mass > 0) || w.norm() == 0) continue;
    const double radius = std::cbrt(3 * fluid_volume(state, i) / (4 * std::numbers::pi));
    const double area = std::numbers::pi * radius * radius * exposure(state, i, w);
    const double share = dt * 0.5 * wind.density * wind.liquid_drag * area * w.norm() / mass;
    s.fluid_velocity[i] = arr(v + share / (1 + share) * w);
  }
}

}  // namespace

void wind(ReferenceState& state, const StepInfo& info, StepReport&) {
  HostState& s = state.s;
  const Model& m = state.model;
  const Vector3d air = vec(m.scene.wind.at(info.time + info.dt));
  if (m.has_moving_cloth()) {
    const Vectors impulse = impulses_on_cloth(state, air, info.dt);
    for (Index n = 0; n < s.node_count(); ++n) {
      s.node_velocity[n] = arr(vec(s.node_velocity[n]) + inverse_node_mass(state, n) * impulse[n]);
      if (m.mesh.is_fixed(n)) s.node_pin_force[n] = arr(vec(s.node_pin_force[n]) - impulse[n] / info.dt);
    }
  }
  if (m.scene.wind.liquid_drag > 0) drag_liquid(state, air, info.dt);
}

}  // namespace drench::reference
