// Stage reservoir of the oracle; the law stands in src/stages/reservoir.hpp.

#include <algorithm>

#include "reference.hpp"

namespace drench::reference {

void reservoir(ReferenceState& state, const StepInfo&, StepReport&) {
  for (const Reservoir& held : state.model.reservoirs) {
    for (std::size_t k = 0; k < held.nodes.size(); ++k) {
      Quanta& liquid = state.s.node_liquid[held.nodes[k]];
      state.s.supplied += held.target[k] - liquid;
      liquid = held.target[k];
      Quanta& buffered = state.s.node_buffered[held.nodes[k]];
      buffered = std::min(buffered, liquid);
    }
  }
}

}  // namespace drench::reference
