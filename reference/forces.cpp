// Stage forces (src/stages/forces.hpp).

#include <algorithm>

#include "rigid_bodies.hpp"

namespace drench::reference {

using Eigen::Vector3d;

void forces(ReferenceState& state, const StepInfo& info, StepReport&) {
  HostState& s = state.s;
  const double h = state.model.support;
  const Smoothing w(state.model);
  const double strength = 10 * state.model.scene.fluid.viscosity;  // 2 (d + 2) ν in d = 3 dimensions
  const Vectors sample = sample_positions(state);
  Vectors sample_force(sample.size(), Vector3d::Zero()), body_force(s.boundary_position.size(), Vector3d::Zero());
  Vectors acceleration(s.fluid_position.size(), vec(state.model.scene.gravity));

  const auto ratio = [&](Index i) { return std::max(0.5, s.fluid_density_ratio[i]); };
  const auto viscous = [&](double volume_over_ratio, const Vector3d& v, const Vector3d& x) -> Vector3d {
    return strength * volume_over_ratio * v.dot(x) / (x.squaredNorm() + 0.01 * h * h) * w.gradient(x);
  };
  for (Index i = 0; i < s.fluid_count(); ++i) {
    const Vector3d xi = vec(s.fluid_position[i]), vi = vec(s.fluid_velocity[i]);
    for (const Index j : state.fluid_fluid[i]) {
      acceleration[i] += viscous(2 * fluid_volume(state, j) / (ratio(i) + ratio(j)), vi - vec(s.fluid_velocity[j]),
                                 xi - vec(s.fluid_position[j]));
    }
    for (const Index b : state.fluid_boundary[i]) {
      const Vector3d a =
          viscous(s.boundary_volume[b] / ratio(i), vi - vec(s.boundary_velocity[b]), xi - vec(s.boundary_position[b]));
      acceleration[i] += a;
      body_force[b] -= fluid_mass(state, i) * a;
    }
    for (const Index b : state.fluid_sample[i]) {
      const Vector3d a = viscous(s.sample_volume[b] / ratio(i), vi - sample_velocity(state, b), xi - sample[b]);
      acceleration[i] += a;
      sample_force[b] -= fluid_mass(state, i) * a;
    }
  }

  for (Index i = 0; i < s.fluid_count(); ++i) {
    s.fluid_velocity[i] = arr(vec(s.fluid_velocity[i]) + info.dt * acceleration[i]);
  }
  const Vectors node_force = spread_to_nodes(state, sample_force);
  for (Index n = 0; n < s.node_count(); ++n) {
    s.node_velocity[n] = arr(vec(s.node_velocity[n]) + info.dt * inverse_node_mass(state, n) * node_force[n]);
    if (state.model.mesh.pinned[n]) s.node_pin_force[n] = arr(vec(s.node_pin_force[n]) - node_force[n]);
  }
  for (Index k = 0; k < s.body_count(); ++k) {
    if (!state.model.bodies[k].dynamic) continue;
    s.body_velocity[k] = arr(vec(s.body_velocity[k]) + info.dt * vec(state.model.scene.gravity));
  }
  accelerate_bodies(state, body_force, info.dt);
}

}  // namespace drench::reference
