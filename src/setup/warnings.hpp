#pragma once
// Warnings of mistakes in a scene that a run survives, badly.

#include <string>
#include <vector>

#include "state/host_state.hpp"
#include "state/model.hpp"

namespace drench {

/// One line each, with numbers and advice: on the step, the spacing, the domain, jets, cloths that fall or are too
/// stiff, reservoirs, sub-steps and frames. Sampling warns of its own (overlaps, pins and boxes that catch nothing).
/// `real_bytes` (4 or 8): of the backend's numbers.
std::vector<std::string> plan_warnings(const Model& model, const HostState& state, int real_bytes);

}  // namespace drench
