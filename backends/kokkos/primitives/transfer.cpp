#include "primitives/transfer.hpp"

namespace drench::kokkos_backend {
namespace {

/// Σ_p w_pn flow_p over a node's samples, in their fixed order.
KOKKOS_INLINE_FUNCTION Quanta node_flow(const Array<Index>& item, Index first, Index last, const Array<double>& weight,
                                        const Array<Quanta>& flow) {
  double sum = 0;
  for (Index e = first; e < last; ++e) {
    const Index p = item(e) / 4;
    sum += weight(3 * p + item(e) % 4) * double(flow(p));
  }
  return static_cast<Quanta>(Kokkos::ceil(sum));
}

/// φ of each sample: the smallest of its nodes'.
void smallest_share(Device& d, const Array<double>& of_node, const Array<double>& of_sample) {
  const auto node = d.samples.node;
  const auto weight = d.samples.weight_exact;
  parallel(
      "drench::transfer::sample_share", d.samples.count, KOKKOS_LAMBDA(const Index p) {
        double share = 1;
        for (int k = 0; k < 3; ++k) {
          const double f = of_node(node(3 * p + k));
          if (weight(3 * p + k) > 0 && f < share) share = f;
        }
        of_sample(p) = share;
      });
}

}  // namespace

void clear_transfers(Device& d, bool momentum) {
  auto& t = d.transfer_work;
  const std::size_t n = static_cast<std::size_t>(d.samples.count);
  make_room(t.entering, "drench::transfer::entering", n);
  if (momentum) make_room(t.momentum, "drench::transfer::momentum", 3 * n);
  const auto entering = t.entering;
  const auto sums = t.momentum;
  parallel(
      "drench::transfer::clear", d.samples.count, KOKKOS_LAMBDA(const Index p) {
        entering(p) = 0;
        if (momentum)
          for (int c = 0; c < 3; ++c) sums(3 * p + c) = 0;
      });
}

void limit_inflow(Device& d) {
  auto& t = d.transfer_work;
  make_room(t.inflow_share, "drench::transfer::inflow_share", static_cast<std::size_t>(d.samples.count));
  make_room(t.node_inflow_share, "drench::transfer::node_inflow_share", static_cast<std::size_t>(d.nodes.count));
  const auto start = d.nodes.sample_start, item = d.nodes.sample_item;
  const auto weight = d.samples.weight_exact;
  const auto entering = t.entering, ceiling = d.nodes.max_quanta, liquid = d.nodes.liquid;
  const auto share = t.node_inflow_share;
  parallel(
      "drench::transfer::node_inflow", d.nodes.count, KOKKOS_LAMBDA(const Index n) {
        share(n) = inflow_fraction(ceiling(n), liquid(n), node_flow(item, start(n), start(n + 1), weight, entering));
      });
  smallest_share(d, share, t.inflow_share);
}

void deliver(Device& d) {
  const auto start = d.nodes.sample_start, item = d.nodes.sample_item;
  const auto weight = d.samples.weight_exact;
  const auto entering = d.transfer_work.entering, liquid = d.nodes.liquid;
  const auto momentum = d.transfer_work.momentum;
  const auto velocity = d.nodes.velocity;
  const auto solid = d.nodes.solid_mass;
  const auto pinned = d.nodes.pinned;
  const double q = d.quantum, unit = d.quantum / momentum_steps;
  parallel(
      "drench::transfer::deliver", d.nodes.count, KOKKOS_LAMBDA(const Index n) {
        Quanta gain = 0;
        double px = 0, py = 0, pz = 0;
        for (Index e = start(n); e < start(n + 1); ++e) {
          const Index p = item(e) / 4;
          const int corner = item(e) % 4;
          if (entering(p) == 0) continue;
          gain += split_part(entering(p), weight(3 * p), weight(3 * p + 1), weight(3 * p + 2), corner);
          const double w = weight(3 * p + corner);
          px += w * double(momentum(3 * p));
          py += w * double(momentum(3 * p + 1));
          pz += w * double(momentum(3 * p + 2));
        }
        const double before = double(solid(n)) + q * double(liquid(n)), after = before + q * double(gain);
        if (!pinned(n) && after > 0 && (px != 0 || py != 0 || pz != 0 || gain != 0)) {
          const Real3 v = velocity(n);
          velocity(n) = {Real((before * double(v.x) + unit * px) / after),
                         Real((before * double(v.y) + unit * py) / after),
                         Real((before * double(v.z) + unit * pz) / after)};
        }
        liquid(n) += gain;
      });
}

}  // namespace drench::kokkos_backend
