#pragma once
// The liquid's pressure, fitted to the solver's by first-order moving least squares: docs/theory/liquid.md, Fitted
// pressure.

#include <vector>

#include "state/host_state.hpp"
#include "state/model.hpp"

namespace drench {

/// Pa, of each particle: the value there of the linear function that fits ρ₀ (κ of both solves) of the particles within
/// h best. Exact for linear fields wherever neighbours lie in all directions of space. The same bits for any number of
/// threads.
std::vector<double> fitted_pressure(const Model& model, const HostState& state, int threads = 1);

}  // namespace drench
