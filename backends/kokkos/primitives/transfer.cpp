#include "primitives/transfer.hpp"

namespace drench::kokkos_backend {
namespace {

/// Σ_p w_pn flow_p over a node's samples, in their fixed order.
KOKKOS_INLINE_FUNCTION Quanta node_flow(const Entries<Index>& item, Index first, Index last,
                                        const Entries<double>& weight, const Entries<Quanta>& flow) {
  double sum = 0;
  DRENCH_UNROLL
  for (Index e = first; e < last; ++e) {
    const Index p = item(e) / 4;
    sum += weight(3 * p + item(e) % 4) * double(flow(p));
  }
  return static_cast<Quanta>(Kokkos::ceil(sum));
}

}  // namespace

void prepare_transfers(Device& d) {
  auto& t = d.transfer_work;
  const std::size_t n = static_cast<std::size_t>(d.samples.count);
  make_room(t.offered, "drench::transfer::offered", n);
  make_room(t.entering, "drench::transfer::entering", n);
  make_room(t.momentum, "drench::transfer::momentum", 3 * n);
  make_room(t.limited, "drench::transfer::limited", n);
  make_room(t.node_inflow_share, "drench::transfer::node_inflow_share", static_cast<std::size_t>(d.nodes.count));
}

void limit_inflow(Device& d, bool limited) {
  const Entries<Index> start = d.nodes.sample_start, item = d.nodes.sample_item;
  const Entries<double> weight = d.samples.weight_exact, of_node = d.transfer_work.node_inflow_share;
  const Entries<Quanta> offered = d.transfer_work.offered, ceiling = d.nodes.max_quanta, liquid = d.nodes.liquid;
  const Entries<int> some = d.transfer_work.limited;
  parallel(
      "drench::transfer::node_inflow", d.nodes.count, KOKKOS_LAMBDA(const Index n) {
        const Quanta inflow = limited ? node_flow(item, start(n), start(n + 1), weight, offered) : 0;
        const double fraction = inflow_fraction(ceiling(n), liquid(n), inflow);
        of_node(n) = fraction;
        if (fraction < 1)
          for (Index e = start(n); e < start(n + 1); ++e)
            if (weight(3 * (item(e) / 4) + item(e) % 4) > 0) Kokkos::atomic_store(&some(item(e) / 4), 1);
      });
}

}  // namespace drench::kokkos_backend
