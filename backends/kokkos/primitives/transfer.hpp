#pragma once
// Integer arithmetic of mass transfers, and how samples pass mass and momentum on to their nodes.

#include "device.hpp"

namespace drench::kokkos_backend {

/// Momentum is summed as integers in units of q · 2^-8 m/s, so that sums do not depend on their order.
inline constexpr double momentum_steps = 256;

KOKKOS_INLINE_FUNCTION std::int64_t fixed_momentum(Quanta mass, Real velocity) {
  return static_cast<std::int64_t>(Kokkos::round(double(mass) * double(velocity) * momentum_steps));
}

/// Adds mass · velocity to the three sums from `at` on.
KOKKOS_INLINE_FUNCTION void add_momentum(const Array<std::int64_t>& sums, Index at, Quanta mass,
                                         const Real3& velocity) {
  Kokkos::atomic_add(&sums(3 * at), fixed_momentum(mass, velocity.x));
  Kokkos::atomic_add(&sums(3 * at + 1), fixed_momentum(mass, velocity.y));
  Kokkos::atomic_add(&sums(3 * at + 2), fixed_momentum(mass, velocity.z));
}

/// floor(a b / c), exact, for a, b ≥ 0 and c > 0 with b ≤ c or a result below 2^63.
KOKKOS_INLINE_FUNCTION Quanta floor_ratio(Quanta a, Quanta b, Quanta c) {
  __extension__ typedef unsigned __int128 Wide;
  return static_cast<Quanta>(static_cast<Wide>(a) * static_cast<Wide>(b) / static_cast<Wide>(c));
}

/// floor(amount · share), with nothing computed where the share is 1. amount ≥ 0.
KOKKOS_INLINE_FUNCTION Quanta limited(Quanta amount, double share) {
  return share >= 1 ? amount : static_cast<Quanta>(Kokkos::floor(double(amount) * share));
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

/// Zeroes transfer_work.entering and, if asked, .momentum (and makes room for them).
void clear_transfers(Device& d, bool momentum);
/// φ of each node from transfer_work.entering and its room, or 1 where not `limited`, and transfer_work.inflow_share
/// φ_j = Σ_n w_jn φ_n of each sample: a full node does not close its triangles. To be followed by deliver().
void limit_inflow(Device& d, bool limited = true);
/// Gives each sample's transfer_work.entering and .momentum to its nodes, by w_jn φ_n/φ_j: mass, and velocity of the
/// nodes that are not
/// pinned.
void deliver(Device& d);

}  // namespace drench::kokkos_backend
