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

/// Node weights of a sample's inflow when each node takes its own part of it, and φ_j.
struct Split {
  double weight[3];
  double share;
};

KOKKOS_INLINE_FUNCTION Split split_of(const Array<double>& weight, const Array<Index>& node,
                                      const Array<double>& of_node, Index p) {
  Split s{{weight(3 * p), weight(3 * p + 1), weight(3 * p + 2)}, 1};
  double share = 0;
  bool any_limited = false;
  for (int k = 0; k < 3; ++k) {
    const double f = of_node(node(3 * p + k));
    if (s.weight[k] > 0 && f < 1) any_limited = true;
    share += s.weight[k] * f;
  }
  if (!any_limited) return s;
  s.share = share;
  for (int k = 0; k < 3; ++k) s.weight[k] = share > 0 ? s.weight[k] * of_node(node(3 * p + k)) / share : s.weight[k];
  return s;
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

void limit_inflow(Device& d, bool limited) {
  auto& t = d.transfer_work;
  make_room(t.inflow_share, "drench::transfer::inflow_share", static_cast<std::size_t>(d.samples.count));
  make_room(t.node_inflow_share, "drench::transfer::node_inflow_share", static_cast<std::size_t>(d.nodes.count));
  const auto start = d.nodes.sample_start, item = d.nodes.sample_item;
  const auto node = d.samples.node;
  const auto weight = d.samples.weight_exact;
  const auto entering = t.entering, ceiling = d.nodes.max_quanta, liquid = d.nodes.liquid;
  const auto of_node = t.node_inflow_share, of_sample = t.inflow_share;
  parallel(
      "drench::transfer::node_inflow", d.nodes.count, KOKKOS_LAMBDA(const Index n) {
        const Quanta inflow = limited ? node_flow(item, start(n), start(n + 1), weight, entering) : 0;
        of_node(n) = inflow_fraction(ceiling(n), liquid(n), inflow);
      });
  parallel(
      "drench::transfer::sample_inflow", d.samples.count,
      KOKKOS_LAMBDA(const Index p) { of_sample(p) = split_of(weight, node, of_node, p).share; });
}

void deliver(Device& d) {
  const auto start = d.nodes.sample_start, item = d.nodes.sample_item;
  const auto weight = d.samples.weight_exact;
  const auto entering = d.transfer_work.entering, liquid = d.nodes.liquid;
  const auto momentum = d.transfer_work.momentum;
  const auto velocity = d.nodes.velocity;
  const auto solid = d.nodes.solid_mass;
  const auto pinned = d.nodes.pinned;
  const auto node = d.samples.node;
  const auto of_node = d.transfer_work.node_inflow_share;
  const double q = d.quantum, unit = d.quantum / momentum_steps;
  parallel(
      "drench::transfer::deliver", d.nodes.count, KOKKOS_LAMBDA(const Index n) {
        Quanta gain = 0;
        double px = 0, py = 0, pz = 0;
        for (Index e = start(n); e < start(n + 1); ++e) {
          const Index p = item(e) / 4;
          const int corner = item(e) % 4;
          if (entering(p) == 0) continue;
          const Split split = split_of(weight, node, of_node, p);
          gain += split_part(entering(p), split.weight[0], split.weight[1], split.weight[2], corner);
          const double w = split.weight[corner];
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
