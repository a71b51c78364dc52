#pragma once
// Laws 1 to 3 of stage self_collision (src/stages/self_collision.hpp) for one node, pair or contact each. A law is a
// struct with a label and `act`; self_collision_course.hpp has their order.

#include "bodies/contact.hpp"
#include "cloth/pins.hpp"
#include "cloth/proximity.hpp"
#include "cloth/self_collision.hpp"
#include "cloth/wet_cloth.hpp"
#include "core/fixed_point.hpp"

namespace drench::kokkos_backend {

#ifdef __CUDA_ARCH__
__device__ inline unsigned lane_of_thread() {
  unsigned lane;
  asm("mov.u32 %0, %%laneid;" : "=r"(lane));
  return lane;
}
#endif

/// A counter's value, which grows by 1. On a GPU lanes that ask together do so once.
KOKKOS_INLINE_FUNCTION Index add_one(Index& counter) {
#ifdef __CUDA_ARCH__
  const unsigned together = __activemask(), lane = lane_of_thread();
  const int leader = __ffs(static_cast<int>(together)) - 1;
  Index first = 0;
  if (lane == static_cast<unsigned>(leader)) first = atomicAdd(&counter, __popc(together));
  return __shfl_sync(together, first, leader) + __popc(together & ((1u << lane) - 1));
#else
  return Kokkos::atomic_fetch_add(&counter, Index{1});
#endif
}

/// What the kernels see.
struct Collision {
  // nodes
  Entries<const Real3> position;
  Entries<Real3> seen, end, node_velocity;
  Entries<NodeVelocity> velocity;
  Entries<const std::uint8_t> pinned, member;
  Entries<const Index> joint;
  Entries<std::uint8_t> changed;
  Entries<const Real> inverse_mass, kept;  // kept: Nodes::clearance
  Entries<const Index> piece, around_start, around;
  Materials materials;
  Slice<const Solid> solids;
  PinMotions pins;
  NodeLiquid wet;
  Entries<std::int64_t> impulse;
  Entries<Index> share;
  // zones
  Entries<Index> zone, stopped, holder, joined;
  Entries<std::int64_t> zone_sum, zone_push;
  // search
  Entries<const Index> corner, rank;
  Entries<const Couple> group_pair;
  Entries<PathBox> box;
  Entries<Couple> close_clusters, candidate;
  Index items, clusters, groups, group_pairs, first_triangle;
  Index cluster_room, candidate_room, pair_room;
  // pairs and contacts
  Entries<ClosePair> pair;
  Entries<Index> hole;
  Entries<Contact> contact;
  Entries<Index> counter;
  double momentum_unit, way_unit, margin;  // kg m/s; m; m
  double full_mass;                        // kg, of all cloth with the liquid that fits
  double parting;                          // 1: of its thickness, what opens of a gap that is too small
  Real dt, half_reach;                     // s; m
  Index nodes;

  Collision(const Constants& constants, const Bodies& bodies, Cloth& cloth, SelfCollisionWork& work,
            const StepInfo& info);

  KOKKOS_INLINE_FUNCTION Clearance clearance(Index n) const {
    const Real thickness = materials(n).thickness;
    return {thickness, kept.exist() ? kept(n) : thickness, materials(n).release * dt, dt};
  }
  KOKKOS_INLINE_FUNCTION Double3 velocity_of(Index n) const {
    const NodeVelocity v = velocity(n);
    return v;
  }
  /// Law 1 for a node with velocity w, and x¹ exactly as stage advection will round it.
  KOKKOS_INLINE_FUNCTION void place(Index n, Double3 w) const {
    const Real3 x = position(n);
    if (pinned(n) || !member(n)) {
      end(n) = pinned(n) && pins.moves(n) ? pins.position(n) : x;
      w = times(1 / double(dt), minus(widen(end(n)), widen(x)));
    } else {
      Real3 shift = dt * narrow(w);
      const Real3 out = project_out(solids, x, shift, clearance(n));
      if (out.x != shift.x || out.y != shift.y || out.z != shift.z) {
        const Real3 v = (1 / dt) * out;
        w = widen(v);
        shift = dt * v;
      }
      end(n) = x + shift;
    }
    velocity(n) = {w};
  }
  /// Must the node's pairs be found again?
  KOKKOS_INLINE_FUNCTION bool has_moved(Index n) const {
    const Double3 by = minus(widen(end(n)), widen(seen(n)));
    return inner(by, by) > margin * margin;
  }
  KOKKOS_INLINE_FUNCTION void watch_end(Index n) const {
    if (has_moved(n)) Kokkos::atomic_store(&counter(ends_moved), Index{1});
  }
  KOKKOS_INLINE_FUNCTION void no_contacts() const { Kokkos::atomic_store(&counter(count_contacts), Index{0}); }
  /// x⁰ of a pair's nodes and their displacements to `ends`, m.
  KOKKOS_INLINE_FUNCTION void paths(const ClosePair& p, const Entries<Real3>& ends, Double3* x, Double3* u) const {
    for (int k = 0; k < 4; ++k) {
      x[k] = widen(position(p.node[k]));
      u[k] = minus(widen(ends(p.node[k])), x[k]);
    }
  }
  /// The surface's normal at a node at the step's beginning, times twice the area of its triangles, m².
  KOKKOS_INLINE_FUNCTION Double3 facing(Index n) const {
    const Double3 x = widen(position(n));
    Double3 sum;
    for (Index r = around_start(n); r < around_start(n + 1); ++r)
      sum = add(sum, outer(minus(widen(position(around(2 * r))), x), minus(widen(position(around(2 * r + 1))), x)));
    return sum;
  }
  /// Normals of two layers that coincide, at the pair. False: nothing tells, or the ends of edges are pairs of their
  /// own.
  KOKKOS_INLINE_FUNCTION bool normals_of_layers(const ClosePair& p, const Double3* x, Double3* normal) const {
    normal[0] = facing(p.node[0]);
    normal[1] = outer(minus(x[2], x[1]), minus(x[3], x[1]));
    if (p.edges != 0) {
      const Double3 a = minus(x[1], x[0]), b = minus(x[3], x[2]), across = outer(a, b);
      if (inner(across, across) < 1e-6 * inner(a, a) * inner(b, b)) return false;
      normal[0] = add(normal[0], facing(p.node[1]));
      normal[1] = add(facing(p.node[2]), facing(p.node[3]));
    }
    for (int k = 0; k < 2; ++k) {
      const double length = Kokkos::sqrt(inner(normal[k], normal[k]));
      if (!(length > 0)) return false;
      normal[k] = times(1 / length, normal[k]);
    }
    return true;
  }
  /// The front of the later of two pieces, as unit vector; `normal` of the first and second of the pair.
  KOKKOS_INLINE_FUNCTION static Double3 front_of_later(const Double3* normal, bool first_is_later) {
    const Double3 own = normal[first_is_later ? 0 : 1], other = normal[first_is_later ? 1 : 0];
    const Double3 mean = inner(own, other) < 0 ? minus(own, other) : add(own, other);
    return times(1 / Kokkos::sqrt(inner(mean, mean)), mean);
  }
  /// Where the first of two layers that coincide goes. False: nothing tells.
  KOKKOS_INLINE_FUNCTION bool side_of_layers(const ClosePair& p, const Double3* x, Double3& side) const {
    Double3 normal[2];
    if (!normals_of_layers(p, x, normal)) return false;
    const Index first = piece(p.node[0]), second = piece(p.node[3]);
    if (first == second && inner(normal[0], normal[1]) >= 0) return false;
    side = front_of_later(normal, first >= second);
    const bool back = first != second && zone_sum(4 * (first > second ? first : second)) < 0;
    if (back != (first < second)) side = times(-1.0, side);
    return true;
  }
  /// Σ b² N/m, 1/kg.
  KOKKOS_INLINE_FUNCTION double inverse(const Contact& c) const {
    double sum = 0;
    for (int k = 0; k < 4; ++k) sum += c.mobility[k] * double(share(c.node[k]));
    return sum;
  }
  /// Σ b v, m/s.
  KOKKOS_INLINE_FUNCTION Double3 relative_velocity(const Contact& c) const {
    Double3 v;
    for (int k = 0; k < 4; ++k) v = add(v, times(c.b[k], velocity_of(c.node[k])));
    return v;
  }
  /// μ of the cloth at node n, as wet as it is there.
  KOKKOS_INLINE_FUNCTION double friction(Index n) const { return double(friction_at(materials(n), wet, n)); }
  KOKKOS_INLINE_FUNCTION void count_in(const Contact& c) const {
    for (int k = 0; k < 4; ++k)
      if (c.b[k] != 0) Kokkos::atomic_add(&share(c.node[k]), Index{1});
  }
  KOKKOS_INLINE_FUNCTION void push(const Contact& c, const Double3& j) const {
    for (int k = 0; k < 4; ++k) {
      const double scale = c.b[k] / momentum_unit;
      if (scale == 0) continue;
      add_fixed(impulse, c.node[k], times(scale, j));
    }
  }
  /// 1/kg; 0 if pinned, also to files.
  KOKKOS_INLINE_FUNCTION double inverse_free_mass(Index n) const { return pinned(n) ? 0.0 : double(inverse_mass(n)); }
  /// Adds a node's impulses to its velocity and clears the sums.
  KOKKOS_INLINE_FUNCTION void apply_impulses(Index n) const {
    if (share(n) == 0) return;
    const double unit = momentum_unit * inverse_free_mass(n);
    const Double3 p{double(impulse(3 * n)), double(impulse(3 * n + 1)), double(impulse(3 * n + 2))};
    place(n, add(velocity_of(n), times(unit, p)));
    for (int a = 0; a < 3; ++a) impulse(3 * n + a) = 0;
    share(n) = 0;
  }
};

/// Law 1, of all nodes.
struct Begin {
  static constexpr const char* label = "drench::self_collision::begin";
  KOKKOS_INLINE_FUNCTION static void act(const Collision& s, Index n) {
    s.place(n, widen(s.node_velocity(n)));
    s.seen(n) = s.end(n);
    s.zone_sum(4 * n) = 0;  // of VoteOnSides, until there are zones
    if (n > 0) return;
    for (Index c = 0; c < collision_counters; ++c) s.counter(c) = 0;
  }
};

/// Is the pair so close that its distance has no direction: of layers that start as one?
KOKKOS_INLINE_FUNCTION bool coincide(const ClosePair& pair) { return pair.distance <= 1e-3 * pair.thickness; }

/// Layers that coincide part to the side to which the later piece goes: at its least node, the sum of its ways to its
/// front.
struct VoteOnSides {
  static constexpr const char* label = "drench::self_collision::sides";
  KOKKOS_INLINE_FUNCTION static void act(const Collision& s, Index p) {
    const ClosePair pair = s.pair(p);
    if (pair.edges != 0 || !coincide(pair)) return;
    const Index first = s.piece(pair.node[0]), second = s.piece(pair.node[3]);
    Double3 x[4], u[4], normal[2], way;
    s.paths(pair, s.end, x, u);
    if (first == second || !s.normals_of_layers(pair, x, normal)) return;
    const Proximity near = proximity(false, x);
    for (int k = 0; k < 4; ++k) way = add(way, times(near.b[k], u[k]));
    const double to_front = inner(Collision::front_of_later(normal, first > second), way);
    Kokkos::atomic_add(&s.zone_sum(4 * (first > second ? first : second)),
                       fixed_point((first > second ? to_front : -to_front) / s.way_unit));
  }
};

constexpr double impulse_part = 0x1p-47;  // unit of impulses, of the heaviest node's mass · 1 m/s
constexpr double longest_lever = 2;       // a node's way over the gap that it opens: docs/theory/contacts.md, (5a)

/// Law 3: is a pair in contact, and how?
struct FindContact {
  static constexpr const char* label = "drench::self_collision::contacts";
  KOKKOS_INLINE_FUNCTION static void act(const Collision& s, Index p) {
    const ClosePair pair = s.pair(p);
    if (pair.edges == dropped_pair) return;
    Double3 x[4], u[4];
    s.paths(pair, s.end, x, u);
    const double tau = pair.thickness, start = pair.distance;
    Proximity near;
    if (start <= tau)
      near = proximity(pair.edges != 0, x);
    else if (!reaches(pair.edges != 0, x, u, tau, near))
      return;
    Contact c{};
    if (coincide(pair)) {
      if (!s.side_of_layers(pair, x, c.normal)) return;
    } else {
      if (!(near.distance > 0)) return;
      c.normal = {near.apart.x / near.distance, near.apart.y / near.distance, near.apart.z / near.distance};
    }
    c.short_of = smaller(tau, start < tau ? start + s.parting * tau : tau);
    double moves = 0, most = 0;  // of the gap and of a node by an impulse, 1/kg
    for (int k = 0; k < 4; ++k) {
      c.node[k] = pair.node[k];
      c.b[k] = near.b[k];
      const double each = c.b[k] * s.inverse_free_mass(c.node[k]);
      c.mobility[k] = c.b[k] * each;
      moves += c.mobility[k];
      most = larger(most, Kokkos::abs(each));
      c.short_of -= c.b[k] * inner(c.normal, minus(x[k], x[0]));
    }
    if (most > longest_lever * moves) return;
    s.contact(add_one(s.counter(count_contacts))) = c;
  }
};

// Law 3, one pass over the contacts: gaps, pushes, impulses.
struct FindGap {
  static constexpr const char* label = "drench::self_collision::gap";
  KOKKOS_INLINE_FUNCTION static void act(const Collision& s, Index k) {
    Contact& c = s.contact(k);
    const double missing = c.short_of - double(s.dt) * inner(c.normal, s.relative_velocity(c));
    const bool acts = missing > 0 || c.impulse > 0;
    c.change = acts ? missing : 0;
    if (acts) s.count_in(c);
  }
};
struct Push {
  static constexpr const char* label = "drench::self_collision::push";
  KOKKOS_INLINE_FUNCTION static void act(const Collision& s, Index k) {
    Contact& c = s.contact(k);
    if (c.change == 0) return;
    const double inverse = s.inverse(c);
    if (!(inverse > 0)) return;
    const double before = c.impulse, after = larger(0.0, before + c.change / (double(s.dt) * inverse));
    c.impulse = after;
    s.push(c, times(after - before, c.normal));
  }
};
struct ApplyImpulses {
  static constexpr const char* label = "drench::self_collision::apply";
  KOKKOS_INLINE_FUNCTION static void act(const Collision& s, Index n) { s.apply_impulses(n); }
};

// Law 3, friction.
struct CountPressed {
  static constexpr const char* label = "drench::self_collision::pressed";
  KOKKOS_INLINE_FUNCTION static void act(const Collision& s, Index k) {
    if (s.contact(k).impulse > 0) s.count_in(s.contact(k));
  }
};
struct ApplyFriction {
  static constexpr const char* label = "drench::self_collision::friction";
  KOKKOS_INLINE_FUNCTION static void act(const Collision& s, Index k) {
    const Contact& c = s.contact(k);
    if (!(c.impulse > 0)) return;
    const double mu = 0.5 * (s.friction(c.node[0]) + s.friction(c.node[3]));
    const double inverse = s.inverse(c);
    Double3 u = s.relative_velocity(c);
    u = minus(u, times(inner(u, c.normal), c.normal));
    const double speed = Kokkos::sqrt(inner(u, u));
    if (!(speed > 0) || !(inverse > 0)) return;
    s.push(c, times(-smaller(mu * c.impulse, speed / inverse) / speed, u));
  }
};
/// The round's last impulses: its contacts are done with.
struct EndRound {
  static constexpr const char* label = "drench::self_collision::end_round";
  KOKKOS_INLINE_FUNCTION static void act(const Collision& s, Index n) {
    s.apply_impulses(n);
    s.watch_end(n);
    if (n == 0) s.no_contacts();
  }
};

/// Hands the velocities on.
struct Finish {
  static constexpr const char* label = "drench::self_collision::velocity";
  KOKKOS_INLINE_FUNCTION static void act(const Collision& s, Index n) {
    if (s.member(n) && !s.pinned(n)) s.node_velocity(n) = narrow(s.velocity_of(n));
  }
};

}  // namespace drench::kokkos_backend
