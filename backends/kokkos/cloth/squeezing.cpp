// Stage squeezing (law: src/stages/squeezing.hpp).

#include "stages/squeezing.hpp"

#include <limits>
#include <utility>

#include "cloth/pins.hpp"
#include "cloth/proximity.hpp"
#include "cloth/squeezing.hpp"
#include "cloth/stages.hpp"
#include "core/fixed_point.hpp"
#include "core/host_copy.hpp"

namespace drench::kokkos_backend {
namespace {

namespace law = squeezing_law;

/// What the kernels see.
struct Squeezing {
  ClothSystem cloth;
  SoftPins soft;
  Entries<const Real> inverse_mass;
  Entries<Double3> pull, smooth, acceleration, wall;
  Entries<std::int64_t> push, load;
  Entries<Index> share, count;
  Entries<PressedPair> pair;
  double unit;  // N

  Squeezing(const ClothSystem& system, const Cloth& fabric, SqueezingWork& work, double force_unit)
      : cloth(system),
        soft(fabric),
        inverse_mass(fabric.nodes.inverse_mass),
        pull(work.pull),
        smooth(work.smooth),
        acceleration(work.acceleration),
        wall(work.wall),
        push(work.push),
        load(work.load),
        share(work.share),
        count(work.count),
        pair(work.pair),
        unit(force_unit) {}

  /// 1/kg; 0 if pinned, also to files.
  KOKKOS_INLINE_FUNCTION double inverse_free_mass(Index n) const {
    return cloth.pinned(n) ? 0.0 : double(inverse_mass(n));
  }
  /// `own` and what the other layers do to a node, N.
  KOKKOS_INLINE_FUNCTION Double3 with_layers(const Double3& own, Index n) const {
    const Double3 pushed{double(push(3 * n)), double(push(3 * n + 1)), double(push(3 * n + 2))};
    return add(own, times(unit, pushed));
  }
  /// Its acceleration, which the first solid that it touches stops.
  KOKKOS_INLINE_FUNCTION void accelerate(Index n) const {
    const Double3 a = times(inverse_free_mass(n), with_layers(smooth(n), n)), normal = wall(n);
    const double into = inner(a, normal);
    acceleration(n) = into < 0 ? minus(a, times(into, normal)) : a;
  }
  KOKKOS_INLINE_FUNCTION void find_force(Index n, const Real3& gravity) const {
    if (n == 0) count(0) = 0;
    const auto at_rest = [](Index) { return Real3{}; };
    const Real mass = cloth.pinned(n) ? cloth.mass(n) : 1 / inverse_mass(n);  // without a soft pin's share
    pull(n) = smooth(n) = widen(cloth.elastic_force(n, at_rest) + mass * gravity + soft.force(n, cloth.start(n)));
    const NodeTerms t = cloth.terms(n);
    Double3 normal;
    for (std::size_t b = 0; b < cloth.solids.extent(0) && !cloth.pinned(n); ++b) {
      const NearSolid<Real> near = near_solid(cloth.solids(b), cloth.start(n), Real3{}, t.clearance);
      if (!ClothSystem::in_contact(near, t)) continue;
      normal = widen(near.at.normal);
      break;
    }
    wall(n) = normal;
    for (int a = 0; a < 3; ++a) push(3 * n + a) = 0;
    load(n) = 0;
    share(n) = 0;
  }

  /// Half of a free node's force goes to those that it shares an edge with, in equal parts; what pins would get stays.
  KOKKOS_INLINE_FUNCTION Double3 spread(const Entries<Double3>& from, Index n) const {
    if (cloth.pinned(n)) return from(n);
    Double3 sum = times(0.5, from(n));
    for (Index r = cloth.edge_start(n); r < cloth.edge_start(n + 1); ++r) {
      const Index e = cloth.edge_item(r), other = cloth.edge(2 * e) == n ? cloth.edge(2 * e + 1) : cloth.edge(2 * e);
      const Index giver = cloth.pinned(other) ? n : other;
      sum = add(sum, times(0.5 / double(cloth.edge_start(giver + 1) - cloth.edge_start(giver)), from(giver)));
    }
    return sum;
  }
  // a pass: who acts, their forces, what these do
  KOKKOS_INLINE_FUNCTION void find_missing(Index k) const {
    PressedPair& c = pair(k);
    double opening = 0;
    for (int i = 0; i < 4; ++i) opening += c.b[i] * inner(c.normal, acceleration(c.node[i]));
    const bool acts = opening < 0 || c.applied > 0;
    c.missing = acts ? -opening : 0;
    for (int i = 0; i < 4 && acts; ++i)
      if (c.b[i] != 0) Kokkos::atomic_add(&share(c.node[i]), Index{1});
  }
  KOKKOS_INLINE_FUNCTION void press(Index k, double momentum) const {
    PressedPair& c = pair(k);
    double inverse = 0;
    for (int i = 0; i < 4 && c.missing != 0; ++i)
      inverse += c.b[i] * c.b[i] * double(share(c.node[i])) * inverse_free_mass(c.node[i]);
    const double after = inverse > 0 ? larger(0.0, c.applied + c.missing / inverse) : c.applied;
    apply(c, larger(0.0, after + momentum * (after - c.force)));
    c.force = after;
  }
  KOKKOS_INLINE_FUNCTION void apply(PressedPair& c, double applied) const {
    const double more = (applied - c.applied) / unit;
    c.applied = applied;
    for (int i = 0; i < 4; ++i)
      if (c.b[i] != 0 && more != 0) add_fixed(push, c.node[i], times(c.b[i] * more, c.normal));
  }
  KOKKOS_INLINE_FUNCTION void end_pass(Index n) const {
    share(n) = 0;
    accelerate(n);
  }
  KOKKOS_INLINE_FUNCTION void add_load(Index k) const {
    const PressedPair& c = pair(k);
    if (!(c.force > 0)) return;
    for (int i = 0; i < 4; ++i)
      if (c.b[i] != 0) Kokkos::atomic_add(&load(c.node[i]), fixed_point(Kokkos::abs(c.b[i]) * c.force / unit));
  }
  /// Half of what presses on the node's two sides in all, N.
  KOKKOS_INLINE_FUNCTION double pressed(Index n) const {
    if (cloth.pinned(n)) return 0.5 * unit * double(load(n));
    const NodeTerms t = cloth.terms(n);
    Real3 left = narrow(with_layers(pull(n), n));
    return 0.5 * (unit * double(load(n)) + double(cloth.contact(t, Real3{}, left, t.compression).press));
  }
};

void allocate(const Cloth& cloth, const SelfCollisionWork& collision, SqueezingWork& work) {
  const auto n = static_cast<std::size_t>(cloth.nodes.count);
  make_room(work.pull, "drench::squeezing::pull", n);
  make_room(work.smooth, "drench::squeezing::smooth", n);
  make_room(work.acceleration, "drench::squeezing::acceleration", n);
  make_room(work.wall, "drench::squeezing::wall", n);
  make_room(work.push, "drench::squeezing::push", 3 * n);
  make_room(work.load, "drench::squeezing::load", n);
  make_room(work.share, "drench::squeezing::share", n);
  if (collision.found_pairs > 0)
    make_ample_room(work.pair, "drench::squeezing::pair", static_cast<std::size_t>(collision.found_pairs));
  make_room(work.count, "drench::squeezing::count", 1);
}

/// The pairs of stage self_collision that touch now; their number.
Index find_pairs(const Cloth& cloth, const SelfCollisionWork& collision, SqueezingWork& work) {
  const Entries<const ClosePair> close = collision.pair;
  const Entries<const Real3> x = cloth.nodes.position;
  const Entries<PressedPair> pair = work.pair;
  const Entries<Index> count = work.count;
  parallel(
      "drench::squeezing::pairs", collision.found_pairs, KOKKOS_LAMBDA(const Index p) {
        const ClosePair at = close(p);
        if (at.edges == dropped_pair) return;
        Double3 place[4];
        for (int k = 0; k < 4; ++k) place[k] = widen(x(at.node[k]));
        const Proximity near = proximity(at.edges != 0, place);
        if (!(near.distance > 0 && near.distance <= law::touching * at.thickness)) return;
        PressedPair c{};
        for (int k = 0; k < 4; ++k) {
          c.node[k] = at.node[k];
          c.b[k] = near.b[k];
        }
        c.normal = times(1 / near.distance, near.apart);
        pair(Kokkos::atomic_fetch_add(&count(0), Index{1})) = c;
      });
  return to_host<Index>(work.count, 1)[0];
}

void balance(const Cloth& cloth, const Squeezing& s, Index pairs) {
  for (int k = 0; k < law::spreads; ++k) {
    const Entries<Double3> from = k % 2 == 0 ? s.smooth : s.acceleration, to = k % 2 == 0 ? s.acceleration : s.smooth;
    parallel(
        "drench::squeezing::spread", cloth.nodes.count, KOKKOS_LAMBDA(const Index n) { to(n) = s.spread(from, n); });
  }
  static_assert(law::spreads % 2 == 0);
  parallel(
      "drench::squeezing::accelerate", cloth.nodes.count, KOKKOS_LAMBDA(const Index n) { s.accelerate(n); });
  for (int pass = 0; pass < law::passes; ++pass) {
    parallel(
        "drench::squeezing::missing", pairs, KOKKOS_LAMBDA(const Index k) { s.find_missing(k); });
    const double momentum = pass + 1 < law::passes ? law::momentum(pass) : 0;
    parallel(
        "drench::squeezing::press", pairs, KOKKOS_LAMBDA(const Index k) { s.press(k, momentum); });
    parallel(
        "drench::squeezing::accelerate", cloth.nodes.count, KOKKOS_LAMBDA(const Index n) { s.end_pass(n); });
  }
  parallel(
      "drench::squeezing::load", pairs, KOKKOS_LAMBDA(const Index k) { s.add_load(k); });
}

/// 1 − Φ of fabric whose Φ is rounded to 1.
constexpr double least_porosity = 0.5 * static_cast<double>(std::numeric_limits<Real>::epsilon());

/// The mean pressure, and what the pores hold under it.
void press_pores(const Constants& constants, Cloth& cloth, const Squeezing& s) {
  const Entries<Real> pressure = cloth.nodes.contact_pressure;
  const Entries<const double> capacity = std::as_const(cloth).nodes.capacity;
  const Entries<double> pores = cloth.nodes.pores;
  const Entries<const double> ceiling = cloth.nodes.ceiling;
  const Entries<Quanta> full = cloth.nodes.capacity_quanta, most = cloth.nodes.max_quanta;
  const Materials materials = node_materials(cloth);
  const double part = 1 - Kokkos::exp(-double(s.cloth.dt) / law::response_time), density = constants.rest_density,
               quantum = constants.quantum;
  parallel(
      "drench::squeezing::pores", cloth.nodes.count, KOKKOS_LAMBDA(const Index n) {
        const Material& m = materials(n);
        if (!(m.compressibility > 0) || !(capacity(n) > 0)) return;
        const double porosity = larger(1 - double(m.solid_fraction), least_porosity);
        const double area = capacity(n) / (density * porosity * double(m.thickness));
        const double now = s.pressed(n) / area, p = double(pressure(n)) + part * (now - double(pressure(n)));
        pressure(n) = Real(p);
        const double taken = p > 0 ? double(m.compressibility) * p / (p + double(m.compression)) : 0;  // of τ
        const double left = 1 - taken / porosity;
        const double holds = larger(left, law::least_pores) * capacity(n);
        pores(n) = holds;
        full(n) = static_cast<Quanta>(Kokkos::floor(holds / quantum));
        const double above = ceiling(n) - 1;  // a film does not shrink with the pores
        most(n) =
            static_cast<Quanta>(Kokkos::floor((holds + above * (m.film_depth > 0 ? capacity(n) : holds)) / quantum));
      });
}

}  // namespace

MemoryEstimate squeezing_bytes(const Sizing& s) {
  MemoryEstimate sum;
  if (!s.size.squeezing || s.size.nodes <= 0) return sum;
  sum.cloth = s.size.nodes * (4 * sizeof(Double3) + 4 * sizeof(std::int64_t) + index_bytes);
  if (s.size.self_collision) sum.cloth += s.size.nodes * 1.25 * s.size.fold_pairs * sizeof(PressedPair);
  return sum;
}

void squeezing(const Constants& constants, Bodies& bodies, Cloth& cloth, ClothSolverWork& solver,
               const SelfCollisionWork& collision, SqueezingWork& work, const StepInfo& info) {
  place_solids(constants, bodies, info);
  place_pins(constants, cloth, info);
  refresh_inverse_mass(constants, cloth);
  allocate(cloth, collision, work);
  const double heaviest = collision.heaviest_node > 0 ? collision.heaviest_node : 1;
  const ClothSystem system = weigh_cloth(constants, bodies, cloth, solver, static_cast<Real>(info.dt));
  const Squeezing s(system, cloth, work, heaviest * 0x1p-32);
  const Real3 gravity = constants.gravity;
  parallel(
      "drench::squeezing::force", cloth.nodes.count, KOKKOS_LAMBDA(const Index n) { s.find_force(n, gravity); });
  const Index pairs = collision.found_pairs > 0 ? find_pairs(cloth, collision, work) : 0;
  if (pairs > 0) balance(cloth, s, pairs);
  press_pores(constants, cloth, s);
}

}  // namespace drench::kokkos_backend
