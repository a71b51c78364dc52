#pragma once
// Particles where no liquid can be, and nodes of cloth inside solids.

#include <string>
#include <vector>

#include "state/host_state.hpp"
#include "state/model.hpp"

namespace drench {

/// Particles (indices in the state) that lie deeper than a spacing inside a solid, or that far outside a container, at
/// a step's end: two solids that overlap hold them there, against stages/advection.hpp, law 4. Left out: those made in
/// the last `step` (s), and bodies without an inside (open meshes). A warning, not a failure: their mass is accounted
/// for.
std::vector<Index> inside_solids(const Model& model, const HostState& state, double step);

/// One line about the free nodes of cloths that are inside solids, "" when there are none.
std::string describe_nodes_inside(const Model& model, const HostState& state);

/// One line about the particles that names the lowest ids, "" when there are none.
std::string describe_lost(const Model& model, const HostState& state, double step);

}  // namespace drench
