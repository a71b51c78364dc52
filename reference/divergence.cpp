// Stage divergence (src/stages/divergence.hpp).

#include "common.hpp"

namespace drench::reference {

void divergence(ReferenceState& state, const StepInfo& info, StepReport& report) {
  constexpr std::size_t fewest_neighbors = 20;
  std::vector<double>& kappa = state.s.fluid_kappa_divergence;
  std::vector<bool> active(kappa.size());
  for (std::size_t i = 0; i < kappa.size(); ++i) {
    const std::size_t near =
        state.fluid_fluid[i].size() + state.fluid_boundary[i].size() + state.fluid_sample[i].size();
    active[i] = near >= fewest_neighbors && state.alpha[i] != 0;
    kappa[i] *= 0.5;
  }
  const Residuals residuals{[&](Index, double rate) { return info.dt * rate; }, {}};
  FreeCloth cloth(state, info.dt);
  const SolveResult result = solve_pressure(state, kappa, active, state.model.scene.fluid.solver.divergence_error, info,
                                            cloth, residuals, info.divergence_start);
  if (state.model.only_liquid_answers()) report.divergence_start = result.start;
  report.divergence_iterations = result.iterations;
  report.divergence_error = result.error;
  report.divergence_converged = result.converged;
}

}  // namespace drench::reference
