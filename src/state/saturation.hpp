#pragma once
// How wet the cloths are.

#include <algorithm>
#include <vector>

#include "state/host_state.hpp"
#include "state/model.hpp"

namespace drench {

/// Of each node of `state`: its liquid over what its pores hold, 1; 0 where the cloth is not porous.
inline std::vector<double> node_saturation(const Model& model, const HostState& state) {
  const std::vector<double>& capacity = model.samples.node_capacity;
  std::vector<double> saturation(state.node_position.size(), 0.0);
  const std::size_t known = std::min({saturation.size(), capacity.size(), state.node_liquid.size()});
  for (std::size_t n = 0; n < known; ++n)
    if (capacity[n] > 0) saturation[n] = static_cast<double>(state.node_liquid[n]) * model.quantum / capacity[n];
  return saturation;
}

}  // namespace drench
