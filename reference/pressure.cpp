// Stage pressure (src/stages/pressure.hpp).

#include <algorithm>

#include "common.hpp"

namespace drench::reference {
namespace {

/// β_i: how much of a fresh particle's compression counts yet.
double source_ramp(const HostState& s, Index i, double ramp) {
  if (s.fluid_origin[i] != static_cast<std::uint8_t>(Origin::cloth) || ramp <= 0) return 1;
  return std::min(1.0, s.fluid_age[i] / ramp);
}

}  // namespace

void pressure(ReferenceState& state, const StepInfo& info, StepReport& report) {
  const HostState& s = state.s;
  const double ramp = emission_ramp(state.model);
  std::vector<bool> active(state.alpha.size());
  for (std::size_t i = 0; i < active.size(); ++i) active[i] = state.alpha[i] != 0;
  const auto residual = [&](Index i, double rate) {
    const double predicted = s.fluid_density_ratio[i] + info.dt * rate;
    return source_ramp(s, i, ramp) * (predicted - 1);
  };
  const SolveResult result = solve_pressure(state, state.s.fluid_kappa_density, active,
                                            state.model.scene.fluid.solver.density_error, info.dt, residual);
  report.density_iterations = result.iterations;
  report.density_error = result.error;
  report.density_error_max = result.error_max;
  report.density_converged = result.converged;
}

}  // namespace drench::reference
