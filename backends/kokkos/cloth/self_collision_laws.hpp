#pragma once
// Laws 1 to 3 of stage self_collision (src/stages/self_collision.hpp) for one node, pair or contact each. A law is a struct
// with a label and `act`; self_collision_course.hpp has their order.

#include "bodies/contact.hpp"
#include "cloth/pins.hpp"
#include "cloth/proximity.hpp"
#include "cloth/self_collision.hpp"
#include "cloth/wet_cloth.hpp"
#include "core/fixed_point.hpp"

namespace drench::kokkos_backend {

/// What the kernels see.
struct Collision {
  // nodes
  Entries<const Real3> position, seen;
  Entries<Real3> end, node_velocity;
  Entries<double> velocity;
  Entries<const std::uint8_t> pinned, member;
  Entries<const Real> inverse_mass;
  Materials materials;
  Slice<const Solid> solids;
  PinMotions pins;
  NodeLiquid wet;
  Entries<std::int64_t> impulse;
  Entries<Index> share;
  // zones
  Entries<Index> zone, stopped, holder;
  Entries<std::uint8_t> joined;
  Entries<std::int64_t> zone_sum, zone_push;
  // pairs and contacts
  Entries<const Index> pair;
  Entries<const double> distance, thickness_of;
  Entries<Index> contact_node;
  Entries<double> weight, normal, target_gap, pair_impulse, change;
  Entries<Index> counter;
  double momentum_unit, way_unit, margin;  // kg m/s; m; m
  Real dt;
  Index nodes, capacity;  // of pairs

  Collision(const Constants& constants, const Bodies& bodies, Cloth& cloth, SelfCollisionWork& work, Real step);

  KOKKOS_INLINE_FUNCTION Double3 velocity_of(Index n) const {
    return {velocity(3 * n), velocity(3 * n + 1), velocity(3 * n + 2)};
  }
  KOKKOS_INLINE_FUNCTION void set_velocity(Index n, const Double3& v) const {
    velocity(3 * n) = v.x;
    velocity(3 * n + 1) = v.y;
    velocity(3 * n + 2) = v.z;
  }
  /// Law 1 for a node with velocity w, and x¹ exactly as stage advection will round it.
  KOKKOS_INLINE_FUNCTION void place(Index n, Double3 w) const {
    const Real3 x = position(n);
    if (pinned(n) || !member(n)) {
      end(n) = pinned(n) && pins.moves(n) ? pins.position(n) : x;
      w = times(1 / double(dt), minus(widen(end(n)), widen(x)));
    } else {
      Real3 shift = dt * narrow(w);
      const Real3 out = project_out(solids, x, shift, materials(n).thickness);
      if (out.x != shift.x || out.y != shift.y || out.z != shift.z) {
        const Real3 v = (1 / dt) * out;
        w = widen(v);
        shift = dt * v;
      }
      end(n) = x + shift;
    }
    set_velocity(n, w);
  }
  /// Raises `ends_moved` if the node's pairs would have to be found again.
  KOKKOS_INLINE_FUNCTION void watch_end(Index n) const {
    const Double3 by = minus(widen(end(n)), widen(seen(n)));
    if (inner(by, by) > margin * margin) Kokkos::atomic_store(&counter(ends_moved), Index{1});
  }
  KOKKOS_INLINE_FUNCTION void no_contacts() const { Kokkos::atomic_store(&counter(count_contacts), Index{0}); }
  /// x⁰ and the displacements of a pair's nodes.
  KOKKOS_INLINE_FUNCTION void paths(Index p, Double3* x, Double3* u) const {
    for (int k = 0; k < 4; ++k) {
      const Index n = pair(5 * p + k);
      x[k] = widen(position(n));
      u[k] = minus(widen(end(n)), x[k]);
    }
  }
  /// A new entry of the list of contacts with the nodes of a pair.
  KOKKOS_INLINE_FUNCTION Index add_contact(Index p) const {
    const Index c = Kokkos::atomic_fetch_add(&counter(count_contacts), Index{1});
    for (int k = 0; k < 4; ++k) contact_node(4 * c + k) = pair(5 * p + k);
    return c;
  }
  KOKKOS_INLINE_FUNCTION Double3 normal_of(Index c) const {
    return {normal(3 * c), normal(3 * c + 1), normal(3 * c + 2)};
  }
  /// n·Σ b x¹ with x¹ not yet rounded, m.
  KOKKOS_INLINE_FUNCTION double gap(Index c) const {
    const Double3 n = normal_of(c), origin = widen(position(contact_node(4 * c)));
    double sum = 0;
    for (int k = 0; k < 4; ++k) {
      const Index node = contact_node(4 * c + k);
      sum += weight(4 * c + k) *
             inner(n, add(minus(widen(position(node)), origin), times(double(dt), velocity_of(node))));
    }
    return sum;
  }
  /// Σ b² N/m, 1/kg.
  KOKKOS_INLINE_FUNCTION double inverse(Index c) const {
    double sum = 0;
    for (int k = 0; k < 4; ++k) {
      const Index node = contact_node(4 * c + k);
      const double b = weight(4 * c + k);
      sum += b * b * double(share(node)) * double(inverse_mass(node));
    }
    return sum;
  }
  /// μ of the cloth at node n, as wet as it is there.
  KOKKOS_INLINE_FUNCTION double friction(Index n) const { return double(friction_at(materials(n), wet, n)); }
  KOKKOS_INLINE_FUNCTION void count_in(Index c) const {
    for (int k = 0; k < 4; ++k)
      if (weight(4 * c + k) != 0) Kokkos::atomic_add(&share(contact_node(4 * c + k)), Index{1});
  }
  KOKKOS_INLINE_FUNCTION void push(Index c, const Double3& j) const {
    for (int k = 0; k < 4; ++k) {
      const double scale = weight(4 * c + k) / momentum_unit;
      if (scale == 0) continue;
      add_fixed(impulse, contact_node(4 * c + k), times(scale, j));
    }
  }
  /// Adds a node's impulses to its velocity and clears the sums.
  KOKKOS_INLINE_FUNCTION void apply_impulses(Index n) const {
    if (share(n) == 0) return;
    const double unit = momentum_unit * double(inverse_mass(n));
    const Double3 p{double(impulse(3 * n)), double(impulse(3 * n + 1)), double(impulse(3 * n + 2))};
    place(n, add(velocity_of(n), times(unit, p)));
    for (int a = 0; a < 3; ++a) impulse(3 * n + a) = 0;
    share(n) = 0;
  }
};

/// Law 1, of all nodes; the counters but that of pairs begin at 0.
struct Begin {
  static constexpr const char* label = "drench::self_collision::begin";
  KOKKOS_INLINE_FUNCTION static void act(const Collision& s, Index n) {
    s.place(n, widen(s.node_velocity(n)));
    if (n > 0) return;
    s.counter(count_contacts) = 0;
    s.counter(ends_moved) = 0;
    s.counter(count_zone_nodes) = 0;
  }
};

/// Law 3: is a pair in contact, and how?
struct FindContact {
  static constexpr const char* label = "drench::self_collision::contacts";
  KOKKOS_INLINE_FUNCTION static void act(const Collision& s, Index p) {
    const Index kind = s.pair(5 * p + 4);
    if (kind == dropped_pair) return;
    Double3 x[4], u[4];
    s.paths(p, x, u);
    const bool edges = kind == pair_of_edges;
    const double tau = s.thickness_of(p), start = s.distance(p);
    Proximity near;
    if (start <= tau)
      near = proximity(edges, x);
    else if (!reaches(edges, x, u, tau, near))
      return;
    if (!(near.distance > 0)) return;
    const Index c = s.add_contact(p);
    for (int k = 0; k < 4; ++k) s.weight(4 * c + k) = near.b[k];
    s.normal(3 * c) = near.apart.x / near.distance;
    s.normal(3 * c + 1) = near.apart.y / near.distance;
    s.normal(3 * c + 2) = near.apart.z / near.distance;
    s.target_gap(c) = Kokkos::fmin(tau, start < tau ? start + 0.1 * tau : tau);
    s.pair_impulse(c) = 0;
  }
};

// Law 3, one pass over the contacts: gaps, pushes, impulses.
struct FindGap {
  static constexpr const char* label = "drench::self_collision::gap";
  KOKKOS_INLINE_FUNCTION static void act(const Collision& s, Index c) {
    const double missing = s.target_gap(c) - s.gap(c);
    const bool acts = missing > 0 || s.pair_impulse(c) > 0;
    s.change(c) = acts ? missing : 0;
    if (acts) s.count_in(c);
  }
};
struct Push {
  static constexpr const char* label = "drench::self_collision::push";
  KOKKOS_INLINE_FUNCTION static void act(const Collision& s, Index c) {
    const double missing = s.change(c);
    if (missing == 0) return;
    const double inverse = s.inverse(c);
    if (!(inverse > 0)) return;
    const double before = s.pair_impulse(c), after = Kokkos::fmax(0.0, before + missing / (double(s.dt) * inverse));
    s.pair_impulse(c) = after;
    s.push(c, times(after - before, s.normal_of(c)));
  }
};
struct ApplyImpulses {
  static constexpr const char* label = "drench::self_collision::apply";
  KOKKOS_INLINE_FUNCTION static void act(const Collision& s, Index n) { s.apply_impulses(n); }
};

// Law 3, friction.
struct CountPressed {
  static constexpr const char* label = "drench::self_collision::pressed";
  KOKKOS_INLINE_FUNCTION static void act(const Collision& s, Index c) {
    if (s.pair_impulse(c) > 0) s.count_in(c);
  }
};
struct ApplyFriction {
  static constexpr const char* label = "drench::self_collision::friction";
  KOKKOS_INLINE_FUNCTION static void act(const Collision& s, Index c) {
    if (!(s.pair_impulse(c) > 0)) return;
    const double mu = 0.5 * (s.friction(s.contact_node(4 * c)) + s.friction(s.contact_node(4 * c + 3)));
    const double inverse = s.inverse(c);
    Double3 u;
    for (int k = 0; k < 4; ++k) u = add(u, times(s.weight(4 * c + k), s.velocity_of(s.contact_node(4 * c + k))));
    const Double3 n = s.normal_of(c);
    u = minus(u, times(inner(u, n), n));
    const double speed = Kokkos::sqrt(inner(u, u));
    if (!(speed > 0) || !(inverse > 0)) return;
    s.push(c, times(-Kokkos::fmin(mu * s.pair_impulse(c), speed / inverse) / speed, u));
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
