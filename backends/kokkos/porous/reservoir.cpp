// Stage reservoir (src/stages/reservoir.hpp).

#include <map>

#include "core/host_copy.hpp"
#include "porous/stages.hpp"
#include "porous/transfer.hpp"

namespace drench::kokkos_backend {
namespace {

/// Targets by node; where boxes overlap the last one holds, as if they were applied one after the other.
void upload_targets(const Constants& constants, ReservoirWork& work) {
  std::map<Index, std::pair<Quanta, double>> targets;
  for (const auto& r : constants.model.reservoirs)
    for (std::size_t k = 0; k < r.nodes.size(); ++k) targets[r.nodes[k]] = {r.target[k], r.solute};
  std::vector<Index> node;
  std::vector<Quanta> target;
  std::vector<double> solute;
  for (const auto& entry : targets) {
    node.push_back(entry.first);
    target.push_back(entry.second.first);
    solute.push_back(entry.second.second);
  }
  work.node = to_device<Index>("drench::reservoir::node", node);
  work.target = to_device<Quanta>("drench::reservoir::target", target);
  if (constants.model.has_solute()) work.solute = to_device<double>("drench::reservoir::solute", solute);
}

/// Of what `hold` is about to supply: at the reservoir's concentration, and of what it takes at the node's.
Quanta supply_solute(Cloth& cloth, const ReservoirWork& work) {
  const Entries<const Index> node = work.node;
  const Entries<const Quanta> target = work.target, liquid = std::as_const(cloth).nodes.liquid;
  const Entries<const double> concentration = work.solute;
  const Entries<Quanta> solute = cloth.nodes.solute;
  Quanta supplied = 0;
  Kokkos::parallel_reduce(
      "drench::reservoir::solute", range(static_cast<Index>(work.node.extent(0))),
      KOKKOS_LAMBDA(const Index k, Quanta& sum) {
        const Index n = node(k);
        const Quanta more = target(k) - liquid(n);
        const Quanta gain = more > 0 ? static_cast<Quanta>(Kokkos::floor(double(more) * concentration(k)))
                                     : -solute_part(solute(n), -more, liquid(n));
        solute(n) += gain;
        sum += gain;
      },
      supplied);
  return supplied;
}

Quanta hold(Cloth& cloth, const ReservoirWork& work) {
  const Slice<const Index> node = work.node;
  const Entries<const Quanta> target = work.target;
  const Entries<Quanta> liquid = cloth.nodes.liquid, buffered = cloth.nodes.buffered;
  Quanta supplied = 0;
  Kokkos::parallel_reduce(
      "drench::reservoir::hold", range(static_cast<Index>(node.extent(0))),
      KOKKOS_LAMBDA(const Index k, Quanta& sum) {
        sum += target(k) - liquid(node(k));
        liquid(node(k)) = target(k);
        if (buffered(node(k)) > target(k)) buffered(node(k)) = target(k);
      },
      supplied);
  return supplied;
}

}  // namespace

void open_reservoirs(const Constants& constants, ReservoirWork& work, Field<double>& in_share) {
  if (work.node.extent(0) == 0) upload_targets(constants, work);
  const Slice<const Index> node = work.node;
  const Entries<double> share = in_share;
  parallel(
      "drench::reservoir::open", static_cast<Index>(node.extent(0)),
      KOKKOS_LAMBDA(const Index k) { share(node(k)) = 1; });
}

void reservoir(const Constants& constants, Cloth& cloth, ReservoirWork& work, Accounts& accounts) {
  cloth.soaked.advance();
  if (work.node.extent(0) == 0) upload_targets(constants, work);
  if (work.node.extent(0) > 0 && constants.model.has_solute()) accounts.solute_supplied += supply_solute(cloth, work);
  if (work.node.extent(0) > 0) accounts.supplied += hold(cloth, work);
}

}  // namespace drench::kokkos_backend
