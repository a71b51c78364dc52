#pragma once
// What a scene may say and should not: mistakes that a run survives, badly.

#include <string>
#include <vector>

#include "state/host_state.hpp"
#include "state/model.hpp"

namespace drench {

/// One line each, with numbers and what to change: a Δt too long for the speeds to come, a spacing too coarse for a body or a
/// cloth (or a cloth too fine for it), a domain that the search has to hash or that is hardly wider than a neighbourhood,
/// jets that never start or whose mouths are where no liquid can be, a cloth that nothing holds or that is too stiff for its solver's cap,
/// reservoirs that feed nothing, stages that repeat themselves many times a step, frames between steps. What sampling finds (overlaps, pins
/// and boxes that catch nothing) is warned of there. `real_bytes` (4 or 8): of the backend's numbers.
std::vector<std::string> plan_warnings(const Model& model, const HostState& state, int real_bytes);

}  // namespace drench
