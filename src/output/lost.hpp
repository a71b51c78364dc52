#pragma once
// Particles where no liquid can be.

#include <string>
#include <vector>

#include "state/host_state.hpp"
#include "state/model.hpp"

namespace drench {

/// Particles (places in the state) that lie deeper than a spacing inside a solid, or that far outside a container, and for
/// how long they have been there is not asked: every step puts them back (stages/advection.hpp, law 4), so one that is there
/// at a step's end is held there by two solids that overlap. Left out: particles that were made in the last `step` (s), as
/// jets and cloth may make them there, and bodies without an inside (open meshes). A warning, not a failure: nothing breaks
/// by it, and the mass is still accounted for.
std::vector<Index> inside_solids(const Model& model, const HostState& state, double step);

/// One line about them that names the lowest ids, "" when there are none.
std::string describe_lost(const Model& model, const HostState& state, double step);

}  // namespace drench
