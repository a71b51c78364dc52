// Stage reservoir of the oracle; the law stands in src/stages/reservoir.hpp.

#include <algorithm>

#include "transfer.hpp"

namespace drench::reference {

namespace {

/// Of what is about to be supplied: at the reservoir's concentration, and of what is taken at the node's.
void supply_solute(ReferenceState& state, const Reservoir& held, Index n, Quanta more) {
  if (!state.model.has_solute()) return;
  HostState& s = state.s;
  const Quanta gain = more > 0 ? floor_quanta(static_cast<double>(more) * held.solute)
                               : -solute_part(s.node_solute[n], -more, s.node_liquid[n]);
  s.node_solute[n] += gain;
  s.solute_supplied += gain;
}

}  // namespace

void reservoir(ReferenceState& state, const StepInfo&, StepReport&) {
  for (const Reservoir& held : state.model.reservoirs) {
    for (std::size_t k = 0; k < held.nodes.size(); ++k) {
      Quanta& liquid = state.s.node_liquid[held.nodes[k]];
      supply_solute(state, held, held.nodes[k], held.target[k] - liquid);
      state.s.supplied += held.target[k] - liquid;
      liquid = held.target[k];
      Quanta& buffered = state.s.node_buffered[held.nodes[k]];
      buffered = std::min(buffered, liquid);
    }
  }
}

}  // namespace drench::reference
