// Stage cloth of the oracle; the law stands in src/stages/cloth.hpp.

#include <algorithm>
#include <cmath>

#include "cloth_problem.hpp"

namespace drench::reference {
namespace {

using Eigen::Vector3d;

constexpr int check_interval = 10;

/// v after Coulomb friction: the tangential part falls by at most `speed` (m/s).
Vector3d slowed(const Vector3d& v, const Vector3d& normal, double speed) {
  const Vector3d across = normal * v.dot(normal);
  const Vector3d along = v - across;
  const double length = along.norm();
  return length > speed ? Vector3d(across + along * (1 - speed / length)) : across;
}

}  // namespace

void cloth(ReferenceState& state, const StepInfo& info, StepReport& report) {
  const Vector3d gravity = vec(state.model.scene.gravity);
  const double dt = info.dt;
  clear_inactive(state);
  const Vectors load = pressure_response(state, state.s.fluid_kappa_density).node_force;

  ClothProblem problem(state, dt);
  Vectors first = problem.start;
  for (Index n = 0; n < state.s.node_count(); ++n) {
    if (!problem.is_free(n)) {
      first[n] += pin_position(state, n, info.time + dt) - pin_position(state, n, info.time);
      continue;
    }
    const ClothMaterial& m = problem.material(n);
    const double damping = m.damping + node_saturation(state, n) * (m.damping_wet - m.damping);
    first[n] += dt * std::exp(-damping * dt) * vec(state.s.node_velocity[n]);
    problem.target[n] = first[n] + dt * dt * (gravity + load[n] / problem.mass[n]);
  }
  ClothIteration iteration(problem, first);
  const int max_iterations = state.model.scene.cloth_solver.max_iterations;
  do {
    iteration.advance(std::min(check_interval, max_iterations - iteration.iterations()));
    report.cloth_residual = iteration.check();
  } while (report.cloth_residual > 1 && iteration.iterations() < max_iterations);
  report.cloth_iterations = iteration.iterations();
  report.cloth_converged = report.cloth_residual <= 1;

  const Vectors& x = iteration.x();
  const Vectors r = problem.residual(x), internal = problem.internal_force(x);
  for (Index n = 0; n < state.s.node_count(); ++n) {
    state.s.node_contact_force[n] = {0, 0, 0};
    Vector3d v = (x[n] - problem.start[n]) / dt;
    if (!problem.is_free(n)) {
      const Vector3d acceleration = (v - vec(state.s.node_velocity[n])) / dt;
      const Vector3d held = internal[n] + problem.mass[n] * (gravity - acceleration) + load[n];
      state.s.node_pin_force[n] = arr(vec(state.s.node_pin_force[n]) - held);
      state.s.node_velocity[n] = arr(v);
      continue;
    }
    const auto [normal, surface] = problem.contact(n, x[n]);
    if (normal.norm() > 0) {
      const double press = std::max(0.0, -r[n].dot(normal));  // N
      const ClothMaterial& m = problem.material(n);
      const double friction = m.friction + node_saturation(state, n) * (m.friction_wet - m.friction);
      v = surface + slowed(v - surface, normal, friction * dt * press / problem.mass[n]);
      state.s.node_contact_force[n] = arr(press * normal);
    }
    state.s.node_velocity[n] = arr(v);
  }
}

}  // namespace drench::reference
