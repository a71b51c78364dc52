// Stage cloth of the oracle; the law stands in src/stages/cloth.hpp.

#include <algorithm>
#include <cmath>
#include <optional>

#include "body_reaction.hpp"

namespace drench::reference {
namespace {

using Eigen::Vector3d;

constexpr int check_interval = 10;

/// Positions at the end of the step, from where the solve before has led (`last`) if there was one; iterations and
/// residual.
Vectors solve(const ReferenceState& state, const StepInfo& info, ClothProblem& problem, const Vectors& load,
              const std::optional<Vectors>& last, StepReport& report) {
  const Vector3d gravity = vec(state.model.scene.gravity);
  const double dt = info.dt;
  Vectors first = problem.start;
  for (Index n = 0; n < state.s.node_count(); ++n) {
    if (!problem.is_free(n)) {
      first[n] += pin_position(state, n, info.time + dt) - pin_position(state, n, info.time);
      continue;
    }
    const ClothMaterial& m = problem.material(n);
    const double damping = m.damping + node_saturation(state, n) * (m.damping_wet - m.damping);
    first[n] += dt * std::exp(-damping * dt) * vec(state.s.node_velocity[n]);
    // The least of m/2Δt² |x − y|² + K/2 |x − X|², with y of the node alone.
    const double held = problem.held[n], mass = node_mass(state, n);
    const Vector3d alone = first[n] + dt * dt * (gravity + load[n] / mass);
    problem.target[n] = alone;
    if (held > 0)
      problem.target[n] =
          (mass * alone + held * dt * dt * pin_position(state, n, info.time + dt)) / (mass + held * dt * dt);
  }
  ClothIteration iteration(problem, last.value_or(first));
  const int max_iterations = state.model.scene.cloth_solver.max_iterations;
  do {
    iteration.advance(std::min(check_interval, max_iterations - iteration.iterations()));
    report.cloth_residual = iteration.check();
  } while (report.cloth_residual > 1 && iteration.iterations() < max_iterations);
  report.cloth_iterations += iteration.iterations();
  if (report.cloth_residual > 1) iteration.line_search();
  return iteration.x();
}

}  // namespace

void cloth(ReferenceState& state, const StepInfo& info, StepReport& report) {
  const Vector3d gravity = vec(state.model.scene.gravity);
  const double dt = info.dt;
  clear_inactive(state);
  const Vectors load = pressure_response(state, state.s.fluid_kappa_density).node_force;

  BodyReaction reaction(state, info);
  std::optional<ClothProblem> solved;
  std::optional<Vectors> found;
  report.cloth_iterations = 0;
  do {
    solved.emplace(state, info);
    found = solve(state, info, *solved, load, found, report);
  } while (reaction.moves_on(*solved, *found));
  report.cloth_residual = std::max(report.cloth_residual, reaction.disagreement());
  report.cloth_converged = report.cloth_residual <= 1;

  const ClothProblem& problem = *solved;
  const Vectors& x = *found;
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
    const double held = problem.held[n];
    if (held > 0)
      state.s.node_pin_force[n] =
          arr(vec(state.s.node_pin_force[n]) + held * (pin_position(state, n, info.time + dt) - x[n]));
    Vector3d free = r[n];
    if (problem.contact(n, x[n], free, 1).press > 0) {
      state.s.node_contact_force[n] = arr(free - r[n]);
      state.s.node_friction_force[n] = arr(problem.unbalanced(n, x[n], r[n]) - free);
    }
    state.s.node_velocity[n] = arr(v);
  }
}

}  // namespace drench::reference
