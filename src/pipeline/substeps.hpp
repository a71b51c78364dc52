#pragma once
// How many parts a stage may take a step in.

#include "pipeline/backend.hpp"

namespace drench {

/// The sub-steps of stage diffusion for the largest exchange rate of the nodes (1/s), as a whole number
/// (stages/substeps.hpp). Throws RunFailure above 10^6, for which no run could wait.
int diffusion_substeps_within_limit(double rate, const StepInfo& info, const StepReport& report);

}  // namespace drench
