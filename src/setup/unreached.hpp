#pragma once
// Drains and probes that no liquid reaches.

#include <string>
#include <vector>

#include "state/model.hpp"

namespace drench {

/// Adds a line for each drain outside the domain or thinner than a particle, and for each probe outside the domain.
void warn_of_unreached(const Model& model, std::vector<std::string>& lines);

}  // namespace drench
