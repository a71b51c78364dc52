// Stage emission (src/stages/emission.hpp), part (d): flag, scan, write.

#include "emission_particles.hpp"

#include "laws/emission.hpp"

namespace drench::kokkos_backend {
namespace {

/// (d): who points to whom, and the pools that are candidates.
void pool(Device& d) {
  const auto& w = d.emission_work;
  const auto rest = w.rest, pools = w.pool;
  const auto blocked = w.blocked;
  const auto target = w.target, count = d.sample_sample.count;
  const auto list = d.sample_sample.list;
  const Layers layers = layers_of(d);
  parallel(
      "drench::emission::target", d.samples.count, KOKKOS_LAMBDA(const Index p) {
        if (rest(p) == 0 || blocked(p)) {
          target(p) = -1;
          return;
        }
        Index best = p;
        for (Index k = 0; k < count(p); ++k) {
          const Index q = list(p, k);
          if (rest(q) == 0 || blocked(q) || !layers.same(p, q)) continue;
          if (rest(q) > rest(best) || (rest(q) == rest(best) && q < best)) best = q;
        }
        target(p) = best;
      });
  const Quanta smallest = d.model.min_quanta;
  parallel(
      "drench::emission::pool", d.samples.count, KOKKOS_LAMBDA(const Index p) {
        Quanta sum = 0;
        if (target(p) == p) {
          sum = rest(p);
          for (Index k = 0; k < count(p); ++k)
            if (target(list(p, k)) == p) sum += rest(list(p, k));
        }
        pools(p) = sum >= smallest ? sum : 0;
      });
}

/// Numbers the candidates in the order of their collectors, and places them. Returns how many there are.
Index place_candidates(Device& d) {
  auto& w = d.emission_work;
  const auto pools = w.pool;
  const auto candidate = w.candidate;
  Index n = 0;
  Kokkos::parallel_scan(
      "drench::emission::candidates", Range(0, d.samples.count),
      KOKKOS_LAMBDA(const Index p, Index& rank, const bool last) {
        if (last) candidate(p) = rank;
        rank += pools(p) > 0 ? 1 : 0;
      },
      n);
  if (n == 0) return 0;
  const std::size_t room = static_cast<std::size_t>(d.samples.count);
  make_room(w.position, "drench::emission::position", room);
  make_room(w.collector, "drench::emission::collector", room);
  make_room(w.created, "drench::emission::created", room);
  make_room(w.rank, "drench::emission::rank", room);
  const auto position = w.position, x = d.samples.position, flow = w.direction;
  const auto collector = w.collector;
  const Real spacing = d.spacing;
  const Quanta full = d.model.max_quanta;
  const bool directed = d.model.has_direction();
  const Real3 down = laws::flow_direction(d.gravity, laws::flow_regularisation(norm(d.gravity), 0));
  parallel(
      "drench::emission::place", d.samples.count, KOKKOS_LAMBDA(const Index p) {
        if (pools(p) == 0) return;
        const Quanta mass = pools(p) < full ? pools(p) : full;
        const Index c = candidate(p);
        collector(c) = p;
        const Real3 towards = directed ? flow(p) : down;
        position(c) = x(p) + laws::emission_distance(spacing, double(mass) / double(quanta_per_particle)) * towards;
      });
  return n;
}

/// Which candidates have space: no liquid, and no candidate of a lower collector, closer than d/2, and not inside the
/// liquid. Returns their number.
Index find_space(Device& d, Index candidates) {
  auto& w = d.emission_work;
  w.cells.build(w.position, candidates, d.spacing);
  // Cells of the liquid where it is now: porous_neighbors made them after advection, and nothing has moved or left
  // since.
  const CellTableView liquid = d.fluid_cells.view(), others = w.cells.view();
  const auto x = d.fluid.position, position = w.position;
  const auto mass = d.fluid.mass;
  const auto created = w.created;
  const Real near2 = d.spacing * d.spacing / 4, reach = d.support;
  const double volume = d.quantum / d.rest_density;  // m³ of a quantum
  const Kernel kernel = d.kernel;
  const bool any_liquid = d.fluid.count > 0;
  parallel(
      "drench::emission::space", candidates, KOKKOS_LAMBDA(const Index c) {
        const Real3 at = position(c);
        bool free = true;
        double filled = 0;
        if (any_liquid)
          liquid.for_cells(liquid.cell_of({at.x - reach, at.y - reach, at.z - reach}),
                           liquid.cell_of({at.x + reach, at.y + reach, at.z + reach}), [&](const Index j) {
                             const Real3 r = x(j) - at;
                             if (mass(j) > 0 && dot(r, r) < near2) free = false;
                             filled += volume * double(mass(j)) * double(kernel.value(norm(r)));
                           });
        others.for_near(at, [&](const Index o) {
          const Real3 r = position(o) - at;
          if (o < c && dot(r, r) < near2) free = false;
        });
        created(c) = free && filled <= laws::surface_share ? 1 : 0;
      });
  const auto ranks = w.rank;
  Index n = 0;
  Kokkos::parallel_scan(
      "drench::emission::rank", Range(0, candidates),
      KOKKOS_LAMBDA(const Index c, Index& rank, const bool last) {
        if (last) ranks(c) = rank;
        rank += created(c);
      },
      n);
  return n;
}

/// Appends the new particles.
void create(Device& d, Index candidates, Index n) {
  const Index first = d.fluid.count;
  d.reserve_fluid(first + n);
  const FluidArrays f = d.fluid;
  const auto& w = d.emission_work;
  const auto created = w.created;
  const auto ranks = w.rank, collector = w.collector, target = w.target, count = d.sample_sample.count;
  const auto list = d.sample_sample.list;
  const auto position = w.position, leaving_velocity = w.velocity;
  const auto pools = w.pool, rest = w.rest;
  const Quanta full = d.model.max_quanta;
  const std::int64_t id = d.next_id;
  parallel(
      "drench::emission::create", candidates, KOKKOS_LAMBDA(const Index c) {
        if (!created(c)) return;
        const Index p = collector(c), i = first + ranks(c);
        Quanta mass = 0;
        double px = 0, py = 0, pz = 0;
        const auto add = [&](const Index g) {
          const Quanta part = pooled_part(rest(g), pools(p), full);
          mass += part;
          px += double(part) * double(leaving_velocity(g).x);
          py += double(part) * double(leaving_velocity(g).y);
          pz += double(part) * double(leaving_velocity(g).z);
        };
        add(p);
        for (Index k = 0; k < count(p); ++k)
          if (target(list(p, k)) == p) add(list(p, k));
        const double inverse = 1 / double(mass);
        f.position(i) = position(c);
        f.velocity(i) = {Real(inverse * px), Real(inverse * py), Real(inverse * pz)};
        f.mass(i) = mass;
        f.id(i) = id + ranks(c);
        f.age(i) = 0;
        f.origin(i) = static_cast<std::uint8_t>(Origin::cloth);
        f.density_ratio(i) = 0;
        f.kappa_density(i) = 0;
        f.kappa_divergence(i) = 0;
      });
  d.fluid.count = first + n;
  d.next_id += n;
}

}  // namespace

Index create_particles(Device& d) {
  if (!d.model.has_direction() && !(norm(d.gravity) > 0)) return 0;  // nowhere to go
  pool(d);
  const Index candidates = place_candidates(d);
  const Index created = candidates > 0 ? find_space(d, candidates) : 0;
  if (created > 0) create(d, candidates, created);
  return created;
}

}  // namespace drench::kokkos_backend
