#pragma once
// What the mass budget keeps constant: all liquid, and all solute, with what left and what came.

#include <numeric>
#include <vector>

#include "state/host_state.hpp"

namespace drench {

inline Quanta sum_of(const std::vector<Quanta>& masses) {
  return std::accumulate(masses.begin(), masses.end(), Quanta{0});
}

/// Liquid in particles and cloth, and what left, less what was supplied, quanta.
inline Quanta liquid_budget(const HostState& s) {
  return sum_of(s.fluid_mass) + sum_of(s.node_liquid) + s.drained + s.evaporated - s.supplied;
}

/// The same of the solute, in its own quanta.
inline Quanta solute_budget(const HostState& s) {
  return sum_of(s.fluid_solute) + sum_of(s.node_solute) + s.solute_drained + s.solute_deposited - s.solute_supplied;
}

}  // namespace drench
