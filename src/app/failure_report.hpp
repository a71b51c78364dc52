#pragma once
// What is said of a run that failed: who, why, and what to change.

#include <string>

#include "output/grids.hpp"
#include "pipeline/failure.hpp"

namespace drench {

/// Who made it fail, in the state that it left: particles and nodes beyond the speed, ends of edges beyond the stretch,
/// particles that are compressed more than the mean, and whatever is no finite number.
Offenders offenders_of(const RunFailure& failure, const Model& model, const HostState& state);

/// One sentence: the likely cause, and the key to change.
std::string advice(const RunFailure& failure, const Model& model, const HostState& state);

}  // namespace drench
