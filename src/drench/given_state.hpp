#pragma once
// States that a program gives to a run: what is checked, and how the mass budget continues.

#include "state/host_state.hpp"
#include "state/model.hpp"

namespace drench {

/// The state without what this model does not need, checked: the number of rows of each field, finite values, masses in
/// their range, ids, orientations.
/// @throws std::invalid_argument naming the field, the first row and what is allowed
HostState checked_state(const Model& model, const HostState& state);

/// @throws std::invalid_argument for a body whose motion the model prescribes and that is elsewhere, or moves
/// differently, than in `before`
void require_prescribed_motion(const Model& model, const HostState& next, const HostState& before);

/// @throws std::invalid_argument for positions, velocities and liquid that are not those of `before` and that no scene
/// could have, or no cloth could hold
void require_possible(const Model& model, const HostState& next, const HostState& before);

/// Enters liquid and solute that `next` has more than `before` as supplied, and what it has less as drained, so that
/// the mass budget of `before` continues.
void continue_budget(HostState& next, const HostState& before);

/// m/s: of the fastest particle or cloth node.
double fastest_of(const HostState& state);

}  // namespace drench
