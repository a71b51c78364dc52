#pragma once
// Integer arithmetic of mass transfers, and how samples pass mass and momentum on to their nodes.

#include "cloth/cloth.hpp"
#include "core/fixed_point.hpp"
#include "core/gather.hpp"
#include "porous/porous_work.hpp"

namespace drench::kokkos_backend {

/// Momentum of a mass, in units of q · 2^-8 m/s (core/fixed_point.hpp).
KOKKOS_INLINE_FUNCTION std::int64_t fixed_momentum(Quanta mass, Real velocity) {
  return fixed_point(double(mass) * double(velocity) * momentum_steps);
}

/// Adds mass · velocity to the three sums from `at` on.
KOKKOS_INLINE_FUNCTION void add_momentum(const Entries<std::int64_t>& sums, Index at, Quanta mass,
                                         const Real3& velocity) {
  Kokkos::atomic_add(&sums(3 * at), fixed_momentum(mass, velocity.x));
  Kokkos::atomic_add(&sums(3 * at + 1), fixed_momentum(mass, velocity.y));
  Kokkos::atomic_add(&sums(3 * at + 2), fixed_momentum(mass, velocity.z));
}

/// floor(a b / c) for a, b ≥ 0 and c > 0 with a result below 2^63: the product in two words, divided a bit at a time.
/// (Not every GPU's compiler divides integers of 128 bits.)
KOKKOS_INLINE_FUNCTION Quanta long_ratio(std::uint64_t a, std::uint64_t b, std::uint64_t c) {
  constexpr std::uint64_t half = 0xffffffff;
  const std::uint64_t low = (a & half) * (b & half), cross = (a >> 32) * (b & half) + (low >> 32);
  const std::uint64_t middle = (a & half) * (b >> 32) + (cross & half);
  const std::uint64_t last = middle << 32 | (low & half);
  std::uint64_t rest = (a >> 32) * (b >> 32) + (cross >> 32) + (middle >> 32), ratio = 0;  // rest < c < 2^63
  for (int bit = 63; bit >= 0; --bit) {
    rest = rest << 1 | (last >> bit & 1);
    ratio <<= 1;
    if (rest >= c) {
      rest -= c;
      ratio |= 1;
    }
  }
  return static_cast<Quanta>(ratio);
}

/// floor(a b / c), exact, for a, b ≥ 0 and c > 0 with b ≤ c or a result below 2^63. A quotient in double is at most one
/// off where it is small enough; its remainder, below 2 c, fits into 64 bits. Long division, many times slower, has the
/// rest.
KOKKOS_INLINE_FUNCTION Quanta floor_ratio(Quanta a, Quanta b, Quanta c) {
  const double quotient = double(a) * double(b) / double(c);
  if (quotient < 0x1p50 && c < Quanta{1} << 60) {
    const auto near = static_cast<Quanta>(quotient);
    const auto rest = static_cast<Quanta>(static_cast<std::uint64_t>(a) * static_cast<std::uint64_t>(b) -
                                          static_cast<std::uint64_t>(near) * static_cast<std::uint64_t>(c));
    return rest < 0 ? near - 1 : rest >= c ? near + 1 : near;
  }
  return long_ratio(static_cast<std::uint64_t>(a), static_cast<std::uint64_t>(b), static_cast<std::uint64_t>(c));
}

/// floor(amount · share), with nothing computed where the share is 1. amount ≥ 0.
KOKKOS_INLINE_FUNCTION Quanta limited(Quanta amount, double share) {
  return share >= 1 ? amount : static_cast<Quanta>(Kokkos::floor(double(amount) * share));
}

/// Of a flow of so many quanta; at most 2⁵⁶, so that those of many add up. No node holds as much.
KOKKOS_INLINE_FUNCTION Quanta offered(double quanta) {
  return static_cast<Quanta>(Kokkos::floor(smaller(quanta, 0x1p56)));
}

KOKKOS_INLINE_FUNCTION Quanta whole_part(double weight, Quanta size) {
  return weight > 0 ? static_cast<Quanta>(Kokkos::floor(weight * double(size))) : 0;
}

/// Node `corner`'s part of a sample's `amount`: floor(w |amount|), the remainder to the largest weight (first of
/// equals). The split of a negative amount is the negative of its magnitude's.
KOKKOS_INLINE_FUNCTION Quanta split_part(Quanta amount, double w0, double w1, double w2, int corner) {
  const Quanta size = amount < 0 ? -amount : amount;
  const Quanta a = whole_part(w0, size);
  const Quanta b = whole_part(w1, size);
  const Quanta c = whole_part(w2, size);
  const int largest = w1 > w0 ? (w2 > w1 ? 2 : 1) : (w2 > w0 ? 2 : 0);
  Quanta part = corner == 0 ? a : corner == 1 ? b : c;
  if (corner == largest) part += size - a - b - c;
  return amount < 0 ? -part : part;
}

/// Quanta of a flow that the limiters keep free, so that splitting into integers cannot overfill or overdraw a node.
KOKKOS_INLINE_FUNCTION Quanta rounding_reserve(Quanta flow) { return (flow >> 16) + 1024; }

/// φ of a node: the part of `inflow` for which it has room below `ceiling`, 1.
KOKKOS_INLINE_FUNCTION double inflow_fraction(Quanta ceiling, Quanta liquid, Quanta inflow) {
  const Quanta room = ceiling - liquid - rounding_reserve(inflow);
  if (inflow <= room || inflow <= 0) return 1;
  return room > 0 ? double(room) / double(inflow) : 0;
}

/// φ of a node: the part of `outflow` that it has, 1.
KOKKOS_INLINE_FUNCTION double outflow_fraction(Quanta liquid, Quanta outflow) {
  const Quanta have = liquid - rounding_reserve(outflow);
  if (outflow <= have || outflow <= 0) return 1;
  return have > 0 ? double(have) / double(outflow) : 0;
}

/// The solute that goes with `part` of a holder's liquid, all of it with all: floor(S part / M), so that several parts
/// of M never ask for more than S.
KOKKOS_INLINE_FUNCTION Quanta solute_part(Quanta solute, Quanta part, Quanta liquid) {
  return part > 0 && solute > 0 ? floor_ratio(solute, part, liquid) : 0;
}

/// Corner's part of a sum of solute that goes along with three parts of liquid: by those, the remainder to the largest
/// (first of equals).
KOKKOS_INLINE_FUNCTION Quanta solute_beside(Quanta solute, const Quanta* part, int corner) {
  const Quanta liquid = part[0] + part[1] + part[2];
  Quanta own = solute_part(solute, part[corner], liquid);
  const int largest = part[1] > part[0] ? (part[2] > part[1] ? 2 : 1) : (part[2] > part[0] ? 2 : 0);
  if (corner != largest) return own;
  own = solute;
  for (int k = 0; k < 3; ++k)
    if (k != corner) own -= solute_part(solute, part[k], liquid);
  return own;
}

/// Node weights of a sample's inflow when each node takes its own part of it, and φ_j.
struct Split {
  double weight[3];
  double share;
};

/// Makes room.
void prepare_transfers(const Constants& constants, const Cloth& cloth, TransferWork& transfers);
MemoryEstimate transfer_bytes(const Sizing& s);
/// φ of each node, node_inflow_share, from `offered` and its room, or 1 where not `limited`; marks
/// the samples of nodes with less than 1.
void limit_inflow(const Cloth& cloth, TransferWork& transfers, bool limited = true);

/// Transfers as kernels see them.
struct Transfers {
  Entries<Quanta> offered, entering;
  Entries<std::int64_t> momentum;
  Entries<const double> weight, of_node;
  Entries<const Index> node;
  Entries<int> limited;
  Entries<Quanta> solute;

  explicit Transfers(const Cloth& cloth, TransferWork& transfers)
      : offered(transfers.offered),
        entering(transfers.entering),
        momentum(transfers.momentum),
        weight(cloth.samples.weight_exact),
        of_node(transfers.node_inflow_share),
        node(cloth.samples.node),
        limited(transfers.limited),
        solute(transfers.solute) {}

  KOKKOS_INLINE_FUNCTION void clear(Index p) const {
    offered(p) = entering(p) = 0;
    limited(p) = 0;
    if (solute.exist()) solute(p) = 0;
    for (int c = 0; c < 3; ++c) momentum(3 * p + c) = 0;
  }
  /// φ_j = Σ_n w_jn φ_n of a sample, after limit_inflow: a full node does not close its triangles.
  KOKKOS_INLINE_FUNCTION double share(Index p) const { return limited(p) ? split(p).share : 1; }
  KOKKOS_INLINE_FUNCTION Split split(Index p) const {
    Split s{{weight(3 * p), weight(3 * p + 1), weight(3 * p + 2)}, 1};
    if (!limited(p)) return s;
    s.share = 0;
    for (int k = 0; k < 3; ++k) s.share += s.weight[k] * of_node(node(3 * p + k));
    if (s.share > 0)
      for (int k = 0; k < 3; ++k) s.weight[k] = s.weight[k] * of_node(node(3 * p + k)) / s.share;
    return s;
  }
  /// `mass` of an offer comes to sample p. What is offered to a sample without limits need not be summed again.
  KOKKOS_INLINE_FUNCTION void give(Index p, Quanta offer, Quanta mass, const Real3& velocity) const {
    const Quanta more = limited(p) ? mass : mass - offer;
    if (more != 0) Kokkos::atomic_add(&entering(p), more);
    if (mass != 0) add_momentum(momentum, p, mass, velocity);
  }
  /// `cut` of a given `mass` does not come after all.
  KOKKOS_INLINE_FUNCTION void take_back(Index p, Quanta mass, Quanta cut, const Real3& velocity) const {
    if (cut == 0) return;
    Kokkos::atomic_add(&entering(p), -cut);
    Kokkos::atomic_add(&momentum(3 * p), fixed_momentum(mass - cut, velocity.x) - fixed_momentum(mass, velocity.x));
    Kokkos::atomic_add(&momentum(3 * p + 1), fixed_momentum(mass - cut, velocity.y) - fixed_momentum(mass, velocity.y));
    Kokkos::atomic_add(&momentum(3 * p + 2), fixed_momentum(mass - cut, velocity.z) - fixed_momentum(mass, velocity.z));
  }
  /// What comes to sample p in all.
  KOKKOS_INLINE_FUNCTION Quanta arriving(Index p) const { return entering(p) + (limited(p) ? 0 : offered(p)); }
};

/// What comes to a node: quanta, and momentum in units of q · 2^-8 m/s.
struct Arrival {
  Quanta gain = 0;
  double px = 0, py = 0, pz = 0;
  KOKKOS_INLINE_FUNCTION Arrival& operator+=(const Arrival& o) {
    gain += o.gain;
    px += o.px;
    py += o.py;
    pz += o.pz;
    return *this;
  }
};

/// Gives each sample's `entering` and `momentum` to its nodes, by w_jn φ_n/φ_j: mass, and velocity, or what pins hold
/// against. For gather_rows over nodes.sample_start.
struct Delivery {
  Transfers transfers;
  Entries<const Index> item;
  Entries<Quanta> liquid;
  Entries<Real3> velocity, pin_force;
  Entries<const Real> solid;
  Entries<const std::uint8_t> fixed;
  double q, unit, inverse_dt;

  Delivery(const Constants& constants, TransferWork& work, Cloth& cloth, double dt)
      : transfers(cloth, work),
        item(cloth.nodes.sample_item),
        liquid(cloth.nodes.liquid),
        velocity(cloth.nodes.velocity),
        pin_force(cloth.nodes.pin_force),
        solid(cloth.nodes.solid_mass),
        fixed(cloth.nodes.fixed),
        q(constants.quantum),
        unit(constants.quantum / momentum_steps),
        inverse_dt(1 / dt) {}

  /// The share of item e's node in what its sample gets.
  KOKKOS_INLINE_FUNCTION Arrival operator()(const Index e) const {
    const Index p = item(e) / 4;
    const int corner = item(e) % 4;
    const Quanta entering = transfers.arriving(p);
    if (entering == 0) return {};
    const Split split = transfers.split(p);
    const double w = split.weight[corner];
    return {split_part(entering, split.weight[0], split.weight[1], split.weight[2], corner),
            w * double(transfers.momentum(3 * p)), w * double(transfers.momentum(3 * p + 1)),
            w * double(transfers.momentum(3 * p + 2))};
  }
  /// Node n has lost `more` quanta beyond those whose momentum went along: it keeps their momentum.
  KOKKOS_INLINE_FUNCTION void keep_momentum(const Index n, double more) const {
    const double mass = double(solid(n)) + q * double(liquid(n));
    if (more == 0 || fixed(n) || !(mass > 0)) return;
    const double factor = 1 + q * more / mass;
    const Real3 v = velocity(n);
    velocity(n) = {Real(factor * double(v.x)), Real(factor * double(v.y)), Real(factor * double(v.z))};
  }
  KOKKOS_INLINE_FUNCTION void operator()(const Index n, const Arrival& in) const {
    const double gained = q * double(in.gain);
    const double before = double(solid(n)) + q * double(liquid(n)), after = before + gained;
    const Real3 v = velocity(n);
    if (fixed(n)) {
      const Double3 brought{unit * in.px, unit * in.py, unit * in.pz};
      const Double3 push = times(inverse_dt, minus(brought, times(gained, widen(v))));
      pin_force(n) = narrow(minus(widen(pin_force(n)), push));
    } else if (after > 0 && (in.px != 0 || in.py != 0 || in.pz != 0 || in.gain != 0)) {
      velocity(n) = {Real((before * double(v.x) + unit * in.px) / after),
                     Real((before * double(v.y) + unit * in.py) / after),
                     Real((before * double(v.z) + unit * in.pz) / after)};
    }
    liquid(n) += in.gain;
  }
};

/// Of a node, quanta.
struct SoluteArrival {
  Quanta gain = 0;
  KOKKOS_INLINE_FUNCTION SoluteArrival& operator+=(const SoluteArrival& o) {
    gain += o.gain;
    return *this;
  }
};

/// Gives each sample's solute to its nodes, as Delivery gives the liquid that brings it.
struct SoluteDelivery {
  Transfers transfers;
  Entries<const Index> item;
  Entries<Quanta> solute;

  SoluteDelivery(Cloth& cloth, TransferWork& work)
      : transfers(cloth, work), item(cloth.nodes.sample_item), solute(cloth.nodes.solute) {}
  KOKKOS_INLINE_FUNCTION Quanta part(Index e) const {
    const Index p = item(e) / 4;
    if (transfers.solute(p) == 0) return 0;
    const Quanta entering = transfers.arriving(p);
    const Split split = transfers.split(p);
    Quanta liquid[3];
    for (int k = 0; k < 3; ++k) liquid[k] = split_part(entering, split.weight[0], split.weight[1], split.weight[2], k);
    return solute_beside(transfers.solute(p), liquid, item(e) % 4);
  }
  KOKKOS_INLINE_FUNCTION SoluteArrival operator()(const Index e) const { return {part(e)}; }
  KOKKOS_INLINE_FUNCTION void operator()(const Index n, const SoluteArrival& in) const { solute(n) += in.gain; }
};

}  // namespace drench::kokkos_backend
