#pragma once
// Impact zones of stage self_collision (law 4 of src/stages/self_collision.hpp), for one node, pair or violating pair
// each.

#include "cloth/self_collision_laws.hpp"

namespace drench::kokkos_backend {

namespace zones {

constexpr double way_units = 1099511627776.0;  // per spacing
// Units of a zone's mass and momentum, as parts of the cloths' mass with all the liquid that fits (times 1 m/s). A sum
// has room for 8 times that mass at 4 km/s; faster nodes count with this speed.
constexpr double mass_part = 0x1p-58, momentum_part = 0x1p-47, fastest = 4096;

/// The least node of n's zone as far as it is joined: no zone's number is above its nodes'.
KOKKOS_INLINE_FUNCTION Index root_of(const Collision& s, Index n) {
  while (true) {
    const Index next = Kokkos::atomic_load(&s.zone(n));
    if (next == n) return n;
    n = next;
  }
}
/// Makes one zone of two: the one with the larger number is hooked to the other, at its root, so that all its nodes go
/// along.
KOKKOS_INLINE_FUNCTION void unite(const Collision& s, Index a, Index b) {
  while (true) {
    a = root_of(s, a);
    b = root_of(s, b);
    if (a == b) return;
    const Index low = a < b ? a : b, high = a < b ? b : a;
    if (Kokkos::atomic_compare_exchange(&s.zone(high), high, low) == high) return;
  }
}
/// A zone's velocity before bodies, m/s.
KOKKOS_INLINE_FUNCTION Double3 velocity(const Collision& s, Index z) {
  const double scale = (momentum_part / mass_part) / double(s.zone_sum(4 * z));
  return {scale * double(s.zone_sum(4 * z + 1)), scale * double(s.zone_sum(4 * z + 2)),
          scale * double(s.zone_sum(4 * z + 3))};
}
/// Does a pair come too near? One that coincides has nowhere to come from: it is law 3 that gives it a direction.
KOKKOS_INLINE_FUNCTION bool violates(const Collision& s, const ClosePair& pair) {
  if (coincide(pair)) return false;
  Double3 x[4], u[4];
  s.paths(pair, s.end, x, u);
  Proximity near;
  return reaches(pair.edges != 0, x, u, smaller(0.25 * pair.thickness, 0.8 * pair.distance), near);
}
KOKKOS_INLINE_FUNCTION void list(const Collision& s, const ClosePair& pair) {
  Contact& c = s.contact(add_one(s.counter(count_contacts)));
  for (int k = 0; k < 4; ++k) c.node[k] = pair.node[k];
}

}  // namespace zones

/// The pairs that violate before there are zones.
struct FindFirstViolation {
  static constexpr const char* label = "drench::self_collision::violations";
  KOKKOS_INLINE_FUNCTION static void act(const Collision& s, Index p) {
    const ClosePair pair = s.pair(p);
    if (pair.edges != dropped_pair && zones::violates(s, pair)) zones::list(s, pair);
  }
};
/// The same later: only pairs with a node in a zone can, for no other nodes have been moved. A zone with a pair of its
/// own that does is to stop.
struct FindViolation {
  static constexpr const char* label = "drench::self_collision::zone_violations";
  KOKKOS_INLINE_FUNCTION static void act(const Collision& s, Index p) {
    const ClosePair pair = s.pair(p);
    if (pair.edges == dropped_pair) return;
    const Index z = s.zone(pair.node[0]);
    bool one = true, moved = false;
    for (int k = 0; k < 4; ++k) {
      const bool joined = s.joined(pair.node[k]) != 0;
      one = one && joined && s.zone(pair.node[k]) == z;
      moved = moved || joined;
    }
    if (!moved || (one && Kokkos::atomic_load(&s.stopped(z)) == 2) || !zones::violates(s, pair)) return;
    zones::list(s, pair);
    if (one) Kokkos::atomic_max(&s.stopped(z), Index{1});
  }
};

struct BeginZones {
  static constexpr const char* label = "drench::self_collision::zones_begin";
  KOKKOS_INLINE_FUNCTION static void act(const Collision& s, Index n) {
    s.zone(n) = n;
    s.joined(n) = 0;
    s.stopped(n) = 0;
  }
};
struct JoinZones {
  static constexpr const char* label = "drench::self_collision::zone_join";
  KOKKOS_INLINE_FUNCTION static void act(const Collision& s, Index c) {
    const Index* const node = s.contact(c).node;
    for (int k = 0; k < 4; ++k) Kokkos::atomic_store(&s.joined(node[k]), Index{1});
    for (int k = 1; k < 4; ++k) zones::unite(s, node[0], node[k]);
  }
};
/// Every node knows its zone's least node; the zones' sums begin.
struct NameZones {
  static constexpr const char* label = "drench::self_collision::zone_names";
  KOKKOS_INLINE_FUNCTION static void act(const Collision& s, Index n) {
    Kokkos::atomic_store(&s.zone(n), zones::root_of(s, n));
    for (int a = 0; a < 4; ++a) s.zone_sum(4 * n + a) = 0;
    for (int a = 0; a < 6; ++a) s.zone_push(6 * n + a) = 0;
    s.holder(n) = no_node;
    if (n == 0) s.no_contacts();
  }
};
/// Mass and momentum of the zones, and which of them are held or stopped.
struct SumZones {
  static constexpr const char* label = "drench::self_collision::zone_sum";
  KOKKOS_INLINE_FUNCTION static void act(const Collision& s, Index n) {
    if (!s.joined(n)) return;
    const Index z = s.zone(n);
    if (Kokkos::atomic_load(&s.stopped(n)) != 0) Kokkos::atomic_max(&s.stopped(z), Index{1});
    if (s.pinned(n)) {
      Kokkos::atomic_min(&s.holder(z), n);
      return;
    }
    const double mass = 1 / (double(s.inverse_mass(n)) * s.full_mass);
    Kokkos::atomic_add(&s.zone_sum(4 * z), fixed_point(mass / zones::mass_part));
    const Double3 v = s.velocity_of(n);
    const double part[3] = {v.x, v.y, v.z};
    for (int a = 0; a < 3; ++a)
      Kokkos::atomic_add(
          &s.zone_sum(4 * z + 1 + a),
          fixed_point(mass / zones::momentum_part * smaller(larger(part[a], -zones::fastest), zones::fastest)));
  }
};
/// The largest ways out of bodies.
struct PushZones {
  static constexpr const char* label = "drench::self_collision::zone_push";
  KOKKOS_INLINE_FUNCTION static void act(const Collision& s, Index n) {
    if (!s.joined(n)) return;
    const Index z = s.zone(n);
    if (s.stopped(z) || s.holder(z) != no_node) return;
    const Real3 shift = s.dt * narrow(zones::velocity(s, z));
    const Real3 out = project_out(s.solids, s.position(n), shift, s.clearance(n)) - shift;
    const double by[3] = {double(out.x), double(out.y), double(out.z)};
    for (int a = 0; a < 3; ++a) {
      const auto size = fixed_point(Kokkos::abs(by[a]) / s.way_unit);
      if (size > 0) Kokkos::atomic_max(&s.zone_push(6 * z + 2 * a + (by[a] > 0 ? 0 : 1)), size);
    }
  }
};
struct MoveZones {
  static constexpr const char* label = "drench::self_collision::zone_move";
  KOKKOS_INLINE_FUNCTION static void act(const Collision& s, Index n) {
    if (!s.joined(n)) return;
    const Index z = s.zone(n);
    const bool still = Kokkos::atomic_load(&s.stopped(z)) != 0;
    if (!s.pinned(n)) {
      Double3 v;
      if (!still && s.holder(z) != no_node) v = s.velocity_of(s.holder(z));
      if (!still && s.holder(z) == no_node) v = add(zones::velocity(s, z), out_of_bodies(s, z));
      s.velocity(n) = {v};
      s.end(n) = s.position(n) + s.dt * narrow(v);
      s.watch_end(n);
    }
    if (still && z == n) Kokkos::atomic_store(&s.stopped(n), Index{2});
  }
  KOKKOS_INLINE_FUNCTION static Double3 out_of_bodies(const Collision& s, Index z) {
    const double scale = s.way_unit / double(s.dt);
    const auto way = [&](int a) { return scale * double(s.zone_push(6 * z + 2 * a) - s.zone_push(6 * z + 2 * a + 1)); };
    return {way(0), way(1), way(2)};
  }
};
struct CountZoneNodes {
  static constexpr const char* label = "drench::self_collision::zone_nodes";
  KOKKOS_INLINE_FUNCTION static void act(const Collision& s, Index n) {
    if (s.joined(n)) add_one(s.counter(count_zone_nodes));
  }
};

}  // namespace drench::kokkos_backend
