#include "primitives/transfer.hpp"

namespace drench::kokkos_backend {
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
  gather_rows<double>(
      "drench::transfer::node_inflow", d.nodes.count, start,
      KOKKOS_LAMBDA(const Index e) {
        const Index p = item(e) / 4;
        return limited ? weight(3 * p + item(e) % 4) * double(offered(p)) : 0.0;
      },
      KOKKOS_LAMBDA(const Index n, const double sum) {
        const double fraction = inflow_fraction(ceiling(n), liquid(n), static_cast<Quanta>(Kokkos::ceil(sum)));
        of_node(n) = fraction;
        if (fraction < 1)
          for (Index e = start(n); e < start(n + 1); ++e)
            if (weight(3 * (item(e) / 4) + item(e) % 4) > 0) Kokkos::atomic_store(&some(item(e) / 4), 1);
      });
}

}  // namespace drench::kokkos_backend
