#pragma once
// The loop of a pressure solve.

#include "base/stop_request.hpp"
#include "fluid/lean_pressure.hpp"
#include "fluid/scaled_start.hpp"

namespace drench::kokkos_backend {

/// Begins with an update of all particles and the sums that judge it.
template <class Update>
SumUnderWay<typename Update::Sums> begin_update(PressureSystem& system, const Update& update,
                                                const PressureIteration& iterate, int slot) {
  if constexpr (has_lean_pressure)
    if (system.lean) return begin_lean_update(system, update, iterate.momentum(), slot);
  return begin_full_update(system, update, slot);
}

/// Solves for κ. A `Problem` makes the update(relaxation), norms(sums) → IterationNorms of its sums and scaled(norms),
/// the residual + complementarity that iterations compare. converged(iteration, sums) judges, and writes the report;
/// gives_up() after it: more iterations would not help.
/// Where scales_start(), start_residual(relaxation) is what the start is scaled by; note_start(mean) takes what it
/// leaves.
template <class Problem>
void solve_pressure(PressureSystem& system, const FluidSolverScene& limits, Problem& problem) {
  constexpr int last_full = 2;
  PressureIteration iterate(system);
  iterate.start();
  // Iteration 1 cannot be the last then: the host does not wait for its sums.
  const bool first_unseen = limits.min_iterations > 1;
  decltype(begin_update(system, problem.update(iterate.relaxation()), iterate, 0)) first;
  for (int iteration = 1;; ++iteration) {
    stop_if_requested();
    system.keep_liquid_rate = has_lean_pressure && iteration == last_full;
    const bool scaled = iteration == 1 && problem.scales_start();
    if (scaled)
      problem.note_start(apply_scaled_start(system, problem.start_residual(iterate.relaxation())));
    else
      apply_pressure(system);
    const auto under_way = begin_update(system, problem.update(iterate.relaxation()), iterate, iteration % 2);
    if (iteration == 1 && first_unseen) {
      first = under_way;
      iterate.advance_first();
      continue;
    }
    const auto sums = over_ranks(system.constants.ranks, under_way.wait());
    if (iteration == 2 && first_unseen) {
      const double start = problem.scaled(problem.norms(over_ranks(system.constants.ranks, first.arrived())));
      iterate.saw_first(start);
      if (!problem.scales_start()) problem.note_start(start);
    }
    const bool converged = problem.converged(iteration, sums);
    if ((converged && iteration >= limits.min_iterations) || iteration >= limits.max_iterations || problem.gives_up())
      break;
    const IterationNorms norms = problem.norms(sums);
    if (iteration == 1 && !scaled) problem.note_start(problem.scaled(norms));
    const bool stepped = system.lean;
    if constexpr (has_lean_pressure)
      if (iteration == last_full) begin_lean_pressure(system);
    system.lean = has_lean_pressure && iteration >= last_full;
    iterate.advance(problem.scaled(norms), problem.scale.restart.value(norms.restart), stepped);
  }
  accept_pressure(system);
}

}  // namespace drench::kokkos_backend
