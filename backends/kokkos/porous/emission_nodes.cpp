// Stage emission (src/stages/emission.hpp), part (e): what leaves the nodes; and the solute that goes along.

#include "porous/emission_particles.hpp"

namespace drench::kokkos_backend {

void share_solute(const Cloth& cloth, EmissionWork& work) {
  const auto samples = static_cast<std::size_t>(cloth.samples.count);
  make_room(work.solute_share, "drench::emission::solute_share", 3 * samples);
  make_room(work.solute_total, "drench::emission::solute_total", samples);
  make_room(work.solute_rest, "drench::emission::solute_rest", samples);
  const Entries<Quanta> share = work.solute_share, total = work.solute_total, rest = work.solute_rest;
  const Entries<const Quanta> mass = std::as_const(work).share, liquid = cloth.nodes.liquid,
                              solute = cloth.nodes.solute;
  const Entries<const Index> node = cloth.samples.node;
  parallel(
      "drench::emission::share_solute", cloth.samples.count, KOKKOS_LAMBDA(const Index p) {
        Quanta sum = 0;
        for (int k = 0; k < 3; ++k) {
          const Index n = node(3 * p + k);
          const Quanta part = solute_part(solute(n), mass(3 * p + k), liquid(n));
          share(3 * p + k) = part;
          sum += part;
        }
        total(p) = rest(p) = sum;
      });
}

namespace {

/// What leaves a node and what comes to it.
struct NodeExchange {
  Quanta out = 0;
  double rounded = 0;  // quanta: `out` less the part of its node in the liquid that took the mean velocity along
  Arrival in;
  KOKKOS_INLINE_FUNCTION NodeExchange& operator+=(const NodeExchange& o) {
    out += o.out;
    rounded += o.rounded;
    in += o.in;
    return *this;
  }
};

/// What a sample gives of `total`, from the node of a corner: by the nodes' shares, the remainder in the order of the
/// corners.
KOKKOS_INLINE_FUNCTION Quanta given_by_node(Quanta given, const Quanta* share, Quanta total, int corner) {
  Quanta part[3], left = given;
  for (int k = 0; k < 3; ++k) {
    part[k] = floor_ratio(given, share[k], total);
    left -= part[k];
  }
  for (int k = 0; k < corner; ++k) {
    const Quanta room = share[k] - part[k];
    left -= left < room ? left : room;
  }
  const Quanta room = share[corner] - part[corner];
  return part[corner] + (left < room ? left : room);
}

/// What samples gave, from their nodes.
struct Leaving {
  Entries<const Quanta> share, total, given;

  explicit Leaving(const EmissionWork& work) : share(work.share), total(work.total), given(work.given) {}
  KOKKOS_INLINE_FUNCTION NodeExchange operator()(Index p, int corner) const {
    const Quanta all = given(p);
    if (all == 0) return {};
    const Quanta own = share(3 * p + corner), out = given_by_node(all, &share(3 * p), total(p), corner);
    return {out, double(out) - double(all) * double(own) / double(total(p)), {}};
  }
};

}  // namespace

void leave_solute(Cloth& cloth, TransferWork& transfers, EmissionWork& work) {
  const Entries<const Quanta> share = std::as_const(work).solute_share, total = std::as_const(work).solute_total,
                              rest = std::as_const(work).solute_rest;
  const SoluteDelivery dissolve(cloth, transfers);
  gather_rows<SoluteArrival>(
      "drench::emission::leave_solute", cloth.nodes.count, cloth.nodes.sample_start,
      KOKKOS_LAMBDA(const Index e) {
        const Index p = dissolve.item(e) / 4;
        const Quanta given = total(p) - rest(p);
        const Quanta out = given == 0 ? 0 : given_by_node(given, &share(3 * p), total(p), dissolve.item(e) % 4);
        return SoluteArrival{dissolve.part(e) - out};
      },
      dissolve);
}

void leave(const Constants& constants, Cloth& cloth, TransferWork& transfers, EmissionWork& work, double dt) {
  const Leaving leaving(work);
  const Maturing matured(constants, cloth, dt);
  const Delivery deliver(constants, transfers, cloth, dt);
  const Entries<int> any = work.any;
  gather_rows<NodeExchange>(
      "drench::emission::leave", cloth.nodes.count, cloth.nodes.sample_start,
      KOKKOS_LAMBDA(const Index e) {
        NodeExchange exchange = leaving(deliver.item(e) / 4, deliver.item(e) % 4);
        exchange.in = deliver(e);
        return exchange;
      },
      KOKKOS_LAMBDA(const Index n, const NodeExchange& sum) {
        if (n == 0) any(0) = any(1) = 0;
        const Quanta before = matured(n);
        deliver.liquid(n) -= sum.out;
        matured.buffered(n) = before > sum.out ? before - sum.out : 0;
        deliver.keep_momentum(n, sum.rounded);
        deliver(n, sum.in);
      });
}

}  // namespace drench::kokkos_backend
