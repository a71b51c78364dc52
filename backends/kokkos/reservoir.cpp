// Stage reservoir (src/stages/reservoir.hpp).

#include <map>

#include "device_copy.hpp"

namespace drench::kokkos_backend {
namespace {

/// Targets by node; where boxes overlap the last one holds, as if they were applied one after the other.
void upload_targets(Device& d) {
  std::map<Index, Quanta> targets;
  for (const auto& r : d.model.reservoirs)
    for (std::size_t k = 0; k < r.nodes.size(); ++k) targets[r.nodes[k]] = r.target[k];
  std::vector<Index> node;
  std::vector<Quanta> target;
  for (const auto& entry : targets) {
    node.push_back(entry.first);
    target.push_back(entry.second);
  }
  d.reservoir_work.node = to_device<Index>("drench::reservoir::node", node);
  d.reservoir_work.target = to_device<Quanta>("drench::reservoir::target", target);
}

Quanta hold(Device& d) {
  const auto node = d.reservoir_work.node;
  const auto target = d.reservoir_work.target, liquid = d.nodes.liquid;
  Quanta supplied = 0;
  Kokkos::parallel_reduce(
      "drench::reservoir::hold", Range(0, static_cast<Index>(node.extent(0))),
      KOKKOS_LAMBDA(const Index k, Quanta& sum) {
        sum += target(k) - liquid(node(k));
        liquid(node(k)) = target(k);
      },
      supplied);
  return supplied;
}

}  // namespace

void reservoir(Device& d, const StepInfo&, StepReport&) {
  if (d.reservoir_work.node.extent(0) == 0) upload_targets(d);
  if (d.reservoir_work.node.extent(0) > 0) d.supplied += hold(d);
}

}  // namespace drench::kokkos_backend
