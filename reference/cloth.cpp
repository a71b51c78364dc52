// Stage cloth of the oracle; the law stands in src/stages/cloth.hpp.

#include <algorithm>
#include <cmath>

#include "cloth_problem.hpp"

namespace drench::reference {
namespace {

using Eigen::Vector3d;

constexpr int check_interval = 10;

}  // namespace

void cloth(ReferenceState& state, const StepInfo& info, StepReport& report) {
  const Vector3d gravity = vec(state.model.scene.gravity);
  const double dt = info.dt;
  clear_inactive(state);
  const Vectors load = pressure_response(state, state.s.fluid_kappa_density).node_force;

  ClothProblem problem(state, info);
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
  if (!report.cloth_converged) iteration.line_search();

  const Vectors& x = iteration.x();
  const Vectors r = problem.residual(x), internal = problem.internal_force(x);
  for (Index n = 0; n < state.s.node_count(); ++n) {
    state.s.node_contact_force[n] = state.s.node_friction_force[n] = {0, 0, 0};
    const Vector3d v = (x[n] - problem.start[n]) / dt;
    if (!problem.is_free(n)) {
      const Vector3d acceleration = (v - vec(state.s.node_velocity[n])) / dt;
      const Vector3d held = internal[n] + problem.mass[n] * (gravity - acceleration) + load[n];
      state.s.node_pin_force[n] = arr(vec(state.s.node_pin_force[n]) - held);
      state.s.node_velocity[n] = arr(v);
      continue;
    }
    Vector3d free = r[n];
    if (problem.contact(n, x[n], free).press > 0) {
      state.s.node_contact_force[n] = arr(free - r[n]);
      state.s.node_friction_force[n] = arr(problem.unbalanced(n, x[n], r[n]) - free);
    }
    state.s.node_velocity[n] = arr(v);
  }
}

}  // namespace drench::reference
