// Stage emission (src/stages/emission.hpp), part (d). A candidate has the number of its collector.

#include "emission_particles.hpp"

#include "laws/emission.hpp"

namespace drench::kokkos_backend {
namespace {

constexpr double share_units = 1099511627776.0;  // 2^40: sums of shares do not depend on their order

void prepare(Device& d) {
  auto& w = d.emission_work;
  const auto samples = static_cast<std::size_t>(d.samples.count);
  make_room(w.target, "drench::emission::target", samples);
  make_room(w.pool, "drench::emission::pool", samples);
  make_room(w.position, "drench::emission::position", samples);
  make_room(w.liquid, "drench::emission::liquid", samples);
  make_room(w.created, "drench::emission::created", samples);
  make_room(w.rank, "drench::emission::rank", samples);
  make_room(w.next, "drench::emission::next", samples);
  const auto buckets = static_cast<std::size_t>(d.sample_cells.view().buckets);
  if (w.head.extent(0) < buckets) {
    make_room(w.head, "drench::emission::head", buckets + buckets / 4);
    Kokkos::deep_copy(ExecSpace(), w.head, Index(-1));
  }
}

/// Who points to whom; nobody to anyone where liquid has nowhere to go.
void target(Device& d) {
  const auto& w = d.emission_work;
  const Entries<Quanta> rest = w.rest;
  const Entries<std::uint8_t> blocked = w.blocked;
  const Entries<Index> target = w.target;
  const Neighbors list(d.sample_sample);
  const Layers layers = layers_of(d);
  const bool leaves = d.model.has_direction() || norm(d.gravity) > 0;
  parallel(
      "drench::emission::target", d.samples.count, KOKKOS_LAMBDA(const Index p) {
        if (!leaves || rest(p) == 0 || blocked(p)) {
          target(p) = -1;
          return;
        }
        Index best = p;
        const NeighborRow near = list.row(p);
        for (Index k = 0; k < near.count; ++k) {
          const Index q = near(k);
          if (rest(q) == 0 || blocked(q) || !layers.same(p, q)) continue;
          if (rest(q) > rest(best) || (rest(q) == rest(best) && q < best)) best = q;
        }
        target(p) = best;
      });
}

/// The pools that are candidates, and where their particles would be.
void pool(Device& d) {
  const auto& w = d.emission_work;
  const Entries<Quanta> rest = w.rest, pools = w.pool;
  const Entries<Index> target = w.target;
  const Entries<Real3> position = w.position, x = d.samples.position, flow = w.direction;
  const Entries<std::int64_t> liquid = w.liquid;
  const Entries<std::uint8_t> created = w.created;
  const Entries<int> any = w.any;
  const Neighbors list(d.sample_sample);
  const CandidateCells cells(d);
  const Quanta smallest = d.model.min_quanta, full = d.model.max_quanta;
  const Real spacing = d.spacing;
  const bool directed = d.model.has_direction();
  const Real3 down = laws::flow_direction(d.gravity, laws::flow_regularisation(norm(d.gravity), 0));
  parallel(
      "drench::emission::pool", d.samples.count, KOKKOS_LAMBDA(const Index p) {
        pools(p) = 0;
        created(p) = 0;
        if (target(p) != p) return;
        Quanta sum = rest(p);
        const NeighborRow near = list.row(p);
        for (Index k = 0; k < near.count; ++k)
          if (target(near(k)) == p) sum += rest(near(k));
        if (sum < smallest) return;
        pools(p) = sum;
        const Quanta mass = sum < full ? sum : full;
        const Real3 towards = directed ? flow(p) : down;
        position(p) = x(p) + laws::emission_distance(spacing, double(mass) / double(quanta_per_particle)) * towards;
        liquid(p) = 0;
        cells.insert(p);
        if (any(1) == 0) Kokkos::atomic_store(&any(1), 1);
      });
}

/// Σ_j V_j W at each candidate, 1 more for liquid that is closer than d/2. The liquid looks for candidates: they are few, and
/// one of them alone with all the liquid around it would keep a GPU's thread busy for longer than all the rest.
void measure_space(Device& d) {
  const auto& w = d.emission_work;
  const Entries<std::int64_t> liquid = w.liquid;
  const Entries<Real3> x = d.fluid.position, position = w.position;
  const Entries<Quanta> mass = d.fluid.mass;
  const Entries<int> any = w.any;
  const CandidateCells cells(d);
  const Kernel kernel = d.kernel;
  const Real near2 = d.spacing * d.spacing / 4, h2 = d.support * d.support;
  const double volume = d.quantum / d.rest_density;  // m³ of a quantum
  parallel(
      "drench::emission::space", d.fluid.count, KOKKOS_LAMBDA(const Index j) {
        if (any(1) == 0 || mass(j) == 0) return;
        const Real3 at = x(j);
        cells.for_near(at, [&](const Index c) {
          const Real3 r = at - position(c);
          const Real r2 = dot(r, r);
          if (!(r2 < h2)) return;
          const double share = volume * double(mass(j)) * double(kernel.value(Kokkos::sqrt(r2))) + (r2 < near2 ? 1 : 0);
          Kokkos::atomic_add(&liquid(c), static_cast<std::int64_t>(Kokkos::round(share_units * share)));
        });
      });
}

/// Numbers the candidates that have space, in the order of their collectors: no liquid, and no candidate of a lower collector,
/// closer than d/2, and not inside the liquid.
void rank(Device& d) {
  const auto& w = d.emission_work;
  const Entries<Quanta> pools = w.pool;
  const Entries<std::int64_t> liquid = w.liquid;
  const Entries<Real3> position = w.position;
  const Entries<std::uint8_t> created = w.created;
  const Entries<Index> ranks = w.rank;
  const CandidateCells cells(d);
  const Real near2 = d.spacing * d.spacing / 4;
  const auto most = static_cast<std::int64_t>(share_units * laws::surface_share);
  auto n = w.new_particles;
  Kokkos::parallel_scan(
      "drench::emission::rank", Range(0, d.samples.count),
      KOKKOS_LAMBDA(const Index c, Index& number, const bool last) {
        if (pools(c) == 0 || liquid(c) > most) return;
        const Real3 at = position(c);
        bool free = true;
        cells.for_near(at, [&](const Index o) {
          const Real3 r = position(o) - at;
          if (o < c && dot(r, r) < near2) free = false;
        });
        if (!free) return;
        if (last) {
          created(c) = 1;
          ranks(c) = number;
        }
        ++number;
      },
      n);
}

/// Appends the new particles (d), and finds out what each sample's nodes lose (e). The candidates' cells are empty again.
void give_out(Device& d, Index new_particles) {
  const Index first = d.fluid.count;
  if (new_particles > 0) d.reserve_fluid(first + new_particles);
  const auto& w = d.emission_work;
  const Entries<Real3> x = d.fluid.position, v = d.fluid.velocity, position = w.position, leaving_velocity = w.velocity;
  const Entries<Quanta> masses = d.fluid.mass, share = w.share, total = w.total, rest = w.rest, pools = w.pool;
  const Entries<std::int64_t> ids = d.fluid.id;
  const Entries<Real> age = d.fluid.age, ratio = d.fluid.density_ratio, kappa_density = d.fluid.kappa_density,
                      kappa_divergence = d.fluid.kappa_divergence;
  const Entries<std::uint8_t> origin = d.fluid.origin, created = w.created;
  const Entries<Index> ranks = w.rank, target = w.target;
  const Neighbors list(d.sample_sample);
  const CandidateCells cells(d);
  const Quanta full = d.model.max_quanta;
  const std::int64_t id = d.next_id;
  parallel(
      "drench::emission::give_out", d.samples.count, KOKKOS_LAMBDA(const Index p) {
        if (pools(p) > 0) cells.clear_cell_of(p);
        if (created(p)) {
          const Index i = first + ranks(p);
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
          const NeighborRow near = list.row(p);
          for (Index k = 0; k < near.count; ++k)
            if (target(near(k)) == p) add(near(k));
          const double inverse = 1 / double(mass);
          x(i) = position(p);
          v(i) = {Real(inverse * px), Real(inverse * py), Real(inverse * pz)};
          masses(i) = mass;
          ids(i) = id + ranks(p);
          age(i) = 0;
          origin(i) = static_cast<std::uint8_t>(Origin::cloth);
          ratio(i) = 0;
          kappa_density(i) = 0;
          kappa_divergence(i) = 0;
        }
        if (total(p) == 0) return;
        Quanta given = total(p) - rest(p);
        const Index q = target(p);
        if (q >= 0 && created(q)) given += pooled_part(rest(p), pools(q), full);
        Quanta left = given;
        Quanta part[3];
        for (int k = 0; k < 3; ++k) {
          part[k] = floor_ratio(given, share(3 * p + k), total(p));
          left -= part[k];
        }
        for (int k = 0; k < 3; ++k) {
          const Quanta room = share(3 * p + k) - part[k];
          const Quanta more = left < room ? left : room;
          share(3 * p + k) = part[k] + more;
          left -= more;
        }
      });
  d.clear_spins(first, new_particles);
  d.fluid.count = first + new_particles;
  d.next_id += new_particles;
}

}  // namespace

void create_particles(Device& d) {
  prepare(d);
  target(d);
  pool(d);
  measure_space(d);
  rank(d);
  ExecSpace().fence("drench::emission::counts");
  const EmissionCounts counts = d.emission_work.counts();
  d.emission_work.idle = counts.ripe == 0;
  if (counts.empty > 0) d.compact_fluid({}, d.fluid.count - counts.empty);
  give_out(d, d.emission_work.new_particles());
}

}  // namespace drench::kokkos_backend
