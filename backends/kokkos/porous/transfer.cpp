#include "porous/transfer.hpp"

namespace drench::kokkos_backend {

void prepare_transfers(const Constants& constants, const Cloth& cloth, TransferWork& transfers) {
  const std::size_t n = static_cast<std::size_t>(cloth.samples.count);
  make_room(transfers.offered, "drench::transfer::offered", n);
  make_room(transfers.entering, "drench::transfer::entering", n);
  make_room(transfers.momentum, "drench::transfer::momentum", 3 * n);
  make_room(transfers.limited, "drench::transfer::limited", n);
  make_room(transfers.node_inflow_share, "drench::transfer::node_inflow_share",
            static_cast<std::size_t>(cloth.nodes.count));
  if (constants.model.has_solute()) make_room(transfers.solute, "drench::transfer::solute", n);
}

MemoryEstimate transfer_bytes(const Sizing& s) {
  MemoryEstimate sum;
  if (!s.size.absorption && !s.size.emission) return sum;
  const double quanta = (s.size.solute ? 3 : 2) * quanta_bytes;
  sum.cloth = s.size.samples * (quanta + 3 * sizeof(std::int64_t) + sizeof(int)) + s.size.nodes * double_bytes;
  return sum;
}

void limit_inflow(const Cloth& cloth, TransferWork& transfers, bool limited) {
  const Entries<const Index> start = cloth.nodes.sample_start, item = cloth.nodes.sample_item;
  const Entries<const double> weight = cloth.samples.weight_exact;
  const Entries<double> of_node = transfers.node_inflow_share;
  const Entries<const Quanta> offered = transfers.offered, ceiling = cloth.nodes.max_quanta,
                              liquid = cloth.nodes.liquid;
  const Entries<int> some = transfers.limited;
  gather_rows<double>(
      "drench::transfer::node_inflow", cloth.nodes.count, start,
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
