// Impact zones of stage self_collision (law 4 of src/stages/self_collision.hpp).

#include "cloth/self_collision_zones.hpp"

#include "bodies/contact.hpp"
#include "cloth/proximity.hpp"
#include "core/fixed_point.hpp"
#include "cloth/self_collision.hpp"

namespace drench::kokkos_backend {
namespace {

constexpr double mass_units = 65536, momentum_units = 4096;  // per quantum; per quantum · m/s
constexpr double way_units = 1099511627776.0;                // per spacing

void begin_zones(const Cloth& cloth, SelfCollisionWork& work) {
  const auto n = static_cast<std::size_t>(cloth.nodes.count);
  allocate_zeros(work.zone, "drench::self_collision::zone", n);
  allocate_zeros(work.joined, "drench::self_collision::joined", n);
  allocate_zeros(work.stopped, "drench::self_collision::stopped", n);
  allocate_zeros(work.holder, "drench::self_collision::holder", n);
  allocate_zeros(work.zone_sum, "drench::self_collision::zone_sum", 4 * n);
  allocate_zeros(work.zone_push, "drench::self_collision::zone_push", 6 * n);
  const Slice<Index> zone = work.zone;
  const Entries<Index> stopped = work.stopped;
  const Entries<std::uint8_t> joined = work.joined;
  parallel(
      "drench::self_collision::zones_begin", cloth.nodes.count, KOKKOS_LAMBDA(const Index i) {
        zone(i) = i;
        joined(i) = 0;
        stopped(i) = 0;
      });
}

/// Marks the pairs that violate: their nodes are to be joined or, if they are one zone, to stop. Returns their number. After
/// the `first` time only pairs with a node in a zone are looked at: no other nodes have been moved.
std::int64_t find_violations(const Cloth& cloth, SelfCollisionWork& work, bool first) {
  const Entries<const Real3> position = cloth.nodes.position, end = work.end;
  const Entries<const Index> pair = work.pair, zone = work.zone;
  const Entries<Index> stopped = work.stopped;
  const Entries<const double> distance = work.distance, thickness = work.thickness_of;
  const Entries<const std::uint8_t> joined = work.joined;
  const Entries<std::uint8_t> bound = work.contact;  // law 3 is done with its marks
  std::int64_t violations = 0;
  Kokkos::parallel_reduce(
      "drench::self_collision::violations", range(work.pairs),
      KOKKOS_LAMBDA(const Index p, std::int64_t& sum) {
        bound(p) = 0;
        const Index kind = pair(5 * p + 4);
        if (kind == dropped_pair) return;
        const Index z = zone(pair(5 * p));
        bool one = true, moved = first;
        for (int k = 0; k < 4; ++k) {
          const Index n = pair(5 * p + k);
          one = one && zone(n) == z && joined(n) != 0;
          moved = moved || joined(n) != 0;
        }
        if (!moved) return;
        if (one && Kokkos::atomic_load(&stopped(z)) == 2) return;
        Double3 x[4], u[4];
        for (int k = 0; k < 4; ++k) {
          const Index n = pair(5 * p + k);
          x[k] = widen(position(n));
          u[k] = minus(widen(end(n)), x[k]);
        }
        Proximity near;
        const double target_gap = Kokkos::fmin(0.25 * thickness(p), 0.8 * distance(p));
        if (!reaches(kind == pair_of_edges, x, u, target_gap, near)) return;
        bound(p) = 1;
        ++sum;
        if (one) Kokkos::atomic_max(&stopped(z), Index{1});
      },
      violations);
  return violations;
}

/// One hooking of the marked pairs' zones to the least among them, and shortening of the ways to it. Returns how many
/// pairs had different zones. Only zones are hooked, not the pairs' nodes: a node of a zone that two pairs hook to different
/// ones must go with the others of its zone, or the pair that it belongs to looks joined and is not.
std::int64_t hook(const Cloth& cloth, SelfCollisionWork& work) {
  const Entries<const Index> pair = work.pair;
  const Entries<Index> zone = work.zone;
  const Entries<const std::uint8_t> bound = work.contact;
  std::int64_t open = 0;
  Kokkos::parallel_reduce(
      "drench::self_collision::hook", range(work.pairs),
      KOKKOS_LAMBDA(const Index p, std::int64_t& sum) {
        if (!bound(p)) return;
        Index root[4], least = pair(5 * p);
        for (int k = 0; k < 4; ++k) {
          root[k] = Kokkos::atomic_load(&zone(pair(5 * p + k)));
          least = root[k] < least ? root[k] : least;
        }
        bool differ = false;
        for (int k = 0; k < 4; ++k) {
          if (root[k] == least) continue;
          differ = true;
          Kokkos::atomic_min(&zone(root[k]), least);
        }
        if (differ) ++sum;
      },
      open);
  if (open == 0) return 0;
  parallel(
      "drench::self_collision::shorten", cloth.nodes.count, KOKKOS_LAMBDA(const Index n) {
        Index root = Kokkos::atomic_load(&zone(n));
        while (true) {
          const Index next = Kokkos::atomic_load(&zone(root));
          if (next == root) break;
          root = next;
        }
        Kokkos::atomic_store(&zone(n), root);
      });
  return open;
}

void join(const Cloth& cloth, SelfCollisionWork& work) {
  const Entries<const Index> pair = work.pair;
  const Entries<const std::uint8_t> bound = work.contact;
  const Entries<std::uint8_t> joined = work.joined;
  parallel(
      "drench::self_collision::join", work.pairs, KOKKOS_LAMBDA(const Index p) {
        if (!bound(p)) return;
        for (int k = 0; k < 4; ++k) Kokkos::atomic_store(&joined(pair(5 * p + k)), std::uint8_t{1});
      });
  while (hook(cloth, work) > 0) {
  }
}

/// Mass and momentum of the zones, and which of them are held or stopped.
void sum_zones(const Constants& constants, const Cloth& cloth, SelfCollisionWork& work) {
  const Entries<const Index> zone = work.zone;
  const Entries<Index> stopped = work.stopped, holder = work.holder;
  const Entries<const std::uint8_t> joined = work.joined, pinned = cloth.nodes.pinned;
  const Entries<std::int64_t> sum = work.zone_sum, push = work.zone_push;
  const Entries<const double> velocity = work.velocity;
  const Entries<const Real> inverse_mass = cloth.nodes.inverse_mass;
  const double quantum = constants.quantum;
  parallel(
      "drench::self_collision::zone_clear", cloth.nodes.count, KOKKOS_LAMBDA(const Index n) {
        for (int a = 0; a < 4; ++a) sum(4 * n + a) = 0;
        for (int a = 0; a < 6; ++a) push(6 * n + a) = 0;
        holder(n) = no_node;
      });
  parallel(
      "drench::self_collision::zone_sum", cloth.nodes.count, KOKKOS_LAMBDA(const Index n) {
        if (!joined(n)) return;
        const Index z = zone(n);
        if (Kokkos::atomic_load(&stopped(n)) != 0) Kokkos::atomic_max(&stopped(z), Index{1});
        if (pinned(n)) {
          Kokkos::atomic_min(&holder(z), n);
          return;
        }
        const double quanta = 1 / (double(inverse_mass(n)) * quantum);
        Kokkos::atomic_add(&sum(4 * z), fixed_point(mass_units * quanta));
        for (int a = 0; a < 3; ++a)
          Kokkos::atomic_add(
              &sum(4 * z + 1 + a),
              fixed_point(momentum_units * quanta * velocity(3 * n + a)));
      });
}

/// A zone's velocity before bodies, m/s.
KOKKOS_INLINE_FUNCTION Double3 zone_velocity(const Entries<const std::int64_t>& sum, Index z) {
  const double scale = mass_units / (momentum_units * double(sum(4 * z)));
  return {scale * double(sum(4 * z + 1)), scale * double(sum(4 * z + 2)), scale * double(sum(4 * z + 3))};
}

void move_zones(const Constants& constants, const Bodies& bodies, const Cloth& cloth, SelfCollisionWork& work, Real dt) {
  const Entries<const Real3> position = cloth.nodes.position;
  const Entries<Real3> end = work.end;
  const Entries<const Index> zone = work.zone, holder = work.holder;
  const Entries<Index> stopped = work.stopped;
  const Entries<const std::uint8_t> joined = work.joined, pinned = cloth.nodes.pinned;
  const Entries<const std::int64_t> sum = work.zone_sum;
  const Entries<std::int64_t> push = work.zone_push;
  const Entries<double> velocity = work.velocity;
  const Slice<const Solid> solids = bodies.solids;
  const Materials materials = node_materials(cloth);
  const double way = double(constants.spacing) / way_units;
  if (solids.extent(0) > 0)
    parallel(
        "drench::self_collision::zone_push", cloth.nodes.count, KOKKOS_LAMBDA(const Index n) {
          const Index z = zone(n);
          if (!joined(n) || stopped(z) || holder(z) != no_node) return;
          const Real3 shift = dt * narrow(zone_velocity(sum, z));
          const Real3 out = project_out(solids, position(n), shift, materials(n).thickness) - shift;
          const double by[3] = {double(out.x), double(out.y), double(out.z)};
          for (int a = 0; a < 3; ++a) {
            const auto size = fixed_point(Kokkos::abs(by[a]) / way);
            if (size > 0) Kokkos::atomic_max(&push(6 * z + 2 * a + (by[a] > 0 ? 0 : 1)), size);
          }
        });
  parallel(
      "drench::self_collision::zone_move", cloth.nodes.count, KOKKOS_LAMBDA(const Index n) {
        if (!joined(n) || pinned(n)) return;
        const Index z = zone(n);
        Double3 v;
        if (holder(z) != no_node && !stopped(z)) {
          const Index h = holder(z);
          v = {velocity(3 * h), velocity(3 * h + 1), velocity(3 * h + 2)};
        } else if (!stopped(z)) {
          const double scale = way / double(dt);
          v = add(zone_velocity(sum, z),
                  {scale * double(push(6 * z) - push(6 * z + 1)), scale * double(push(6 * z + 2) - push(6 * z + 3)),
                   scale * double(push(6 * z + 4) - push(6 * z + 5))});
        }
        velocity(3 * n) = v.x;
        velocity(3 * n + 1) = v.y;
        velocity(3 * n + 2) = v.z;
        end(n) = position(n) + dt * narrow(v);
      });
  parallel(
      "drench::self_collision::zone_stopped", cloth.nodes.count, KOKKOS_LAMBDA(const Index n) {
        if (stopped(n) == 1 && zone(n) == n) stopped(n) = 2;
      });
}

std::int64_t joined_nodes(const Cloth& cloth, const SelfCollisionWork& work) {
  const Entries<const std::uint8_t> joined = work.joined;
  std::int64_t nodes = 0;
  Kokkos::parallel_reduce(
      "drench::self_collision::zone_nodes", range(cloth.nodes.count),
      KOKKOS_LAMBDA(const Index n, std::int64_t& sum) { sum += joined(n); }, nodes);
  return nodes;
}

}  // namespace

std::int64_t join_zones(const Constants& constants, const Bodies& bodies, const Cloth& cloth, SelfCollisionWork& work, Real dt, const std::function<void()>& renew) {
  bool any = false;
  begin_zones(cloth, work);
  while (true) {
    renew();
    if (find_violations(cloth, work, !any) == 0) break;
    any = true;
    join(cloth, work);
    sum_zones(constants, cloth, work);
    move_zones(constants, bodies, cloth, work, dt);
  }
  return any ? joined_nodes(cloth, work) : 0;
}

}  // namespace drench::kokkos_backend
