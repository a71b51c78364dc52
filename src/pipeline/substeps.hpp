#pragma once
// How many parts a stage may take a step in.

#include "pipeline/backend.hpp"

namespace drench {

/// The number of sub-steps that stage diffusion asks for, as a whole number of at least 1. Throws RunFailure above 10^6, for
/// which no run could wait; an int would not even hold 10^10.
int diffusion_substeps(double wanted, const StepInfo& info, const StepReport& report);

}  // namespace drench
