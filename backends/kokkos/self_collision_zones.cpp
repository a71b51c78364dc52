// Impact zones of stage self_collision (law 4 of src/stages/self_collision.hpp).

#include "self_collision_zones.hpp"

#include "device.hpp"
#include "laws/contact.hpp"
#include "laws/proximity.hpp"
#include "self_collision.hpp"

namespace drench::kokkos_backend {
namespace {

constexpr double mass_units = 65536, momentum_units = 4096;  // per quantum; per quantum · m/s
constexpr double way_units = 1099511627776.0;                // per spacing

void begin_zones(Device& d) {
  SelfCollisionWork& w = d.self_collision_work;
  const auto n = static_cast<std::size_t>(d.nodes.count);
  if (w.zone.extent(0) < n) {
    w.zone = Array<Index>("drench::self_collision::zone", n);
    w.joined = Array<std::uint8_t>("drench::self_collision::joined", n);
    w.stopped = Array<Index>("drench::self_collision::stopped", n);
    w.holder = Array<Index>("drench::self_collision::holder", n);
    w.zone_sum = Array<std::int64_t>("drench::self_collision::zone_sum", 4 * n);
    w.zone_push = Array<std::int64_t>("drench::self_collision::zone_push", 6 * n);
  }
  const auto zone = w.zone, stopped = w.stopped;
  const auto joined = w.joined;
  parallel(
      "drench::self_collision::zones_begin", d.nodes.count, KOKKOS_LAMBDA(const Index i) {
        zone(i) = i;
        joined(i) = 0;
        stopped(i) = 0;
      });
}

/// Marks the pairs that violate: their nodes are to be joined or, if they are one zone, to stop. Returns their number. After
/// the `first` time only pairs with a node in a zone are looked at: no other nodes have been moved.
std::int64_t find_violations(Device& d, bool first) {
  const SelfCollisionWork& w = d.self_collision_work;
  const auto position = d.nodes.position, end = w.end;
  const auto pair = w.pair, zone = w.zone, stopped = w.stopped;
  const auto distance = w.distance, thickness = w.thickness_of;
  const auto joined = w.joined, bound = w.contact;  // law 3 is done with its marks
  std::int64_t violations = 0;
  Kokkos::parallel_reduce(
      "drench::self_collision::violations", Range(0, w.pairs),
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
        const double goal = Kokkos::fmin(0.25 * thickness(p), 0.8 * distance(p));
        if (!reaches(kind == pair_of_edges, x, u, goal, near)) return;
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
std::int64_t hook(Device& d) {
  const SelfCollisionWork& w = d.self_collision_work;
  const auto pair = w.pair, zone = w.zone;
  const auto bound = w.contact;
  std::int64_t open = 0;
  Kokkos::parallel_reduce(
      "drench::self_collision::hook", Range(0, w.pairs),
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
      "drench::self_collision::shorten", d.nodes.count, KOKKOS_LAMBDA(const Index n) {
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

void join(Device& d) {
  const SelfCollisionWork& w = d.self_collision_work;
  const auto pair = w.pair;
  const auto bound = w.contact, joined = w.joined;
  parallel(
      "drench::self_collision::join", w.pairs, KOKKOS_LAMBDA(const Index p) {
        if (!bound(p)) return;
        for (int k = 0; k < 4; ++k) Kokkos::atomic_store(&joined(pair(5 * p + k)), std::uint8_t{1});
      });
  while (hook(d) > 0) {
  }
}

/// Mass and momentum of the zones, and which of them are held or stopped.
void sum_zones(Device& d) {
  const SelfCollisionWork& w = d.self_collision_work;
  const auto zone = w.zone, stopped = w.stopped, holder = w.holder;
  const auto joined = w.joined, pinned = d.nodes.pinned;
  const auto sum = w.zone_sum, push = w.zone_push;
  const auto velocity = w.velocity;
  const auto inverse_mass = d.nodes.inverse_mass;
  const double quantum = d.quantum;
  parallel(
      "drench::self_collision::zone_clear", d.nodes.count, KOKKOS_LAMBDA(const Index n) {
        for (int a = 0; a < 4; ++a) sum(4 * n + a) = 0;
        for (int a = 0; a < 6; ++a) push(6 * n + a) = 0;
        holder(n) = no_node;
      });
  parallel(
      "drench::self_collision::zone_sum", d.nodes.count, KOKKOS_LAMBDA(const Index n) {
        if (!joined(n)) return;
        const Index z = zone(n);
        if (Kokkos::atomic_load(&stopped(n)) != 0) Kokkos::atomic_max(&stopped(z), Index{1});
        if (pinned(n)) {
          Kokkos::atomic_min(&holder(z), n);
          return;
        }
        const double quanta = 1 / (double(inverse_mass(n)) * quantum);
        Kokkos::atomic_add(&sum(4 * z), static_cast<std::int64_t>(Kokkos::floor(mass_units * quanta + 0.5)));
        for (int a = 0; a < 3; ++a)
          Kokkos::atomic_add(
              &sum(4 * z + 1 + a),
              static_cast<std::int64_t>(Kokkos::floor(momentum_units * quanta * velocity(3 * n + a) + 0.5)));
      });
}

/// A zone's velocity before bodies, m/s.
KOKKOS_INLINE_FUNCTION Double3 zone_velocity(const Array<std::int64_t>& sum, Index z) {
  const double scale = mass_units / (momentum_units * double(sum(4 * z)));
  return {scale * double(sum(4 * z + 1)), scale * double(sum(4 * z + 2)), scale * double(sum(4 * z + 3))};
}

void move_zones(Device& d, Real dt) {
  const SelfCollisionWork& w = d.self_collision_work;
  const auto position = d.nodes.position, end = w.end;
  const auto zone = w.zone, stopped = w.stopped, holder = w.holder, cloth = d.nodes.cloth;
  const auto joined = w.joined, pinned = d.nodes.pinned;
  const auto sum = w.zone_sum, push = w.zone_push;
  const auto velocity = w.velocity;
  const auto solids = d.solids;
  const auto materials = d.materials;
  const double way = double(d.spacing) / way_units;
  if (solids.extent(0) > 0)
    parallel(
        "drench::self_collision::zone_push", d.nodes.count, KOKKOS_LAMBDA(const Index n) {
          const Index z = zone(n);
          if (!joined(n) || stopped(z) || holder(z) != no_node) return;
          const Real3 shift = dt * narrow(zone_velocity(sum, z));
          const Real3 out = project_out(solids, position(n), shift, materials(cloth(n)).thickness) - shift;
          const double by[3] = {double(out.x), double(out.y), double(out.z)};
          for (int a = 0; a < 3; ++a) {
            const auto size = static_cast<std::int64_t>(Kokkos::floor(Kokkos::abs(by[a]) / way + 0.5));
            if (size > 0) Kokkos::atomic_max(&push(6 * z + 2 * a + (by[a] > 0 ? 0 : 1)), size);
          }
        });
  parallel(
      "drench::self_collision::zone_move", d.nodes.count, KOKKOS_LAMBDA(const Index n) {
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
      "drench::self_collision::zone_stopped", d.nodes.count, KOKKOS_LAMBDA(const Index n) {
        if (stopped(n) == 1 && zone(n) == n) stopped(n) = 2;
      });
}

std::int64_t joined_nodes(const Device& d) {
  const auto joined = d.self_collision_work.joined;
  std::int64_t nodes = 0;
  Kokkos::parallel_reduce(
      "drench::self_collision::zone_nodes", Range(0, d.nodes.count),
      KOKKOS_LAMBDA(const Index n, std::int64_t& sum) { sum += joined(n); }, nodes);
  return nodes;
}

}  // namespace

std::int64_t join_zones(Device& d, Real dt, const std::function<void()>& renew) {
  bool any = false;
  begin_zones(d);
  while (true) {
    renew();
    if (find_violations(d, !any) == 0) break;
    any = true;
    join(d);
    sum_zones(d);
    move_zones(d, dt);
  }
  return any ? joined_nodes(d) : 0;
}

}  // namespace drench::kokkos_backend
