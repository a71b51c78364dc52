// Stage emission (src/stages/emission.hpp), part (d). A candidate has the number of its collector.

#include "porous/emission_particles.hpp"

#include "porous/emission_law.hpp"
#include "porous/faces.hpp"

namespace drench::kokkos_backend {
namespace {

void prepare(const Cloth& cloth, EmissionWork& work) {
  const auto samples = static_cast<std::size_t>(cloth.samples.count);
  make_room(work.target, "drench::emission::target", samples);
  make_room(work.pool, "drench::emission::pool", samples);
  make_room(work.given, "drench::emission::given", samples);
  make_room(work.position, "drench::emission::position", samples);
  make_room(work.liquid, "drench::emission::liquid", samples);
  make_room(work.created, "drench::emission::created", samples);
  make_room(work.rank, "drench::emission::rank", samples);
  make_room(work.next, "drench::emission::next", samples);
  const auto buckets = static_cast<std::size_t>(cloth.sample_cells.view().buckets);
  if (make_ample_room(work.head, "drench::emission::head", buckets)) Kokkos::deep_copy(exec(), work.head, Index(-1));
}

}  // namespace

/// As if something dripped from the first step on.
MemoryEstimate candidate_bytes(const Sizing& s) {
  MemoryEstimate sum;
  // target, rank, next; pool, given; position; liquid; created
  sum.cloth = s.size.samples * (3 * index_bytes + 2 * quanta_bytes + 3 * s.real + sizeof(std::int64_t) + 1);
  sum.cloth += 1.25 * s.size.sample_cells * index_bytes;  // head
  return sum;
}

namespace {

/// Who points to whom; nobody to anyone where liquid has nowhere to go.
void target(const Constants& constants, const NeighborLists& lists, const Cloth& cloth, EmissionWork& work) {
  const Entries<const Quanta> rest = work.rest;
  const Entries<const std::uint8_t> blocked = work.blocked;
  const Entries<Index> target = work.target;
  const Neighbors list(lists.sample_sample);
  const Layers layers = layers_of(constants, cloth);
  const bool leaves = constants.model.has_direction() || norm(constants.gravity) > 0;
  parallel(
      "drench::emission::target", cloth.samples.count, KOKKOS_LAMBDA(const Index p) {
        if (!leaves || rest(p) == 0 || blocked(p)) {
          target(p) = -1;
          return;
        }
        Index best = p;
        list.for_each(p, [&](Index q) {
          if (rest(q) == 0 || blocked(q) || !layers.same(p, q)) return;
          if (rest(q) > rest(best) || (rest(q) == rest(best) && q < best)) best = q;
        });
        target(p) = best;
      });
}

/// The pools that are candidates, and where their particles would be.
void pool(const Constants& constants, const NeighborLists& lists, const Cloth& cloth, EmissionWork& work) {
  const Entries<const Quanta> rest = work.rest;
  const Entries<Quanta> pools = work.pool;
  const Entries<const Index> target = work.target;
  const Entries<Real3> position = work.position;
  const Entries<const Real3> x = cloth.samples.position, flow = leaving_directions(cloth, work);
  const Entries<std::int64_t> liquid = work.liquid;
  const Entries<std::uint8_t> created = work.created;
  const Entries<int> any = work.any;
  const Neighbors list(lists.sample_sample);
  const CandidateCells cells(cloth, work);
  const Quanta smallest = constants.model.min_quanta, full = constants.model.max_quanta;
  const Real spacing = constants.spacing;
  const bool directed = constants.model.has_direction();
  const Real3 down = laws::flow_direction(constants.gravity, laws::flow_regularisation(norm(constants.gravity), 0));
  parallel(
      "drench::emission::pool", cloth.samples.count, KOKKOS_LAMBDA(const Index p) {
        pools(p) = 0;
        created(p) = 0;
        if (target(p) != p) return;
        Quanta sum = rest(p);
        list.for_each(p, [&](Index q) {
          if (target(q) == p) sum += rest(q);
        });
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

/// Σ_j V_j W at each candidate, 16 more for liquid that is closer than d/2. The liquid looks for candidates: they are
/// few, and one of them alone with all the liquid around it would keep a GPU's thread busy for longer than all the
/// rest.
void measure_space(const Constants& constants, const Fluid& fluid, const Cloth& cloth, EmissionWork& work) {
  const Entries<std::int64_t> liquid = work.liquid;
  const Entries<const Real3> x = fluid.particles.position, position = work.position;
  const Entries<const Quanta> mass = fluid.particles.mass;
  const Entries<const int> any = work.any;
  const CandidateCells cells(cloth, work);
  const Kernel kernel = constants.kernel;
  const Real near2 = constants.spacing * constants.spacing / 4, h2 = constants.support * constants.support;
  const double volume = constants.quantum / constants.rest_density;  // m³ of a quantum
  parallel(
      "drench::emission::space", fluid.particles.count, KOKKOS_LAMBDA(const Index j) {
        if (any(1) == 0 || mass(j) == 0) return;
        const Real3 at = x(j);
        cells.for_near(at, [&](const Index c) {
          const Real3 r = at - position(c);
          const Real r2 = dot(r, r);
          if (!(r2 < h2)) return;
          const double share = volume * double(mass(j)) * double(kernel.value(Kokkos::sqrt(r2))) +
                               (r2 < near2 ? laws::crowded_share : 0);
          Kokkos::atomic_add(&liquid(c), fixed_point(share_units * share));
        });
      });
}

/// Numbers the candidates that have space, in the order of their collectors: no liquid, and no candidate of a lower
/// collector, closer than d/2, and not inside the liquid, which only pressure pushes more into.
void rank(const Constants& constants, const Cloth& cloth, EmissionWork& work) {
  const Entries<const Quanta> pools = work.pool;
  const Entries<const std::int64_t> liquid = work.liquid;
  const Entries<const Real3> position = work.position;
  const Entries<std::uint8_t> created = work.created;
  const Entries<Index> ranks = work.rank;
  const CandidateCells cells(cloth, work);
  const Real near2 = constants.spacing * constants.spacing / 4;
  const auto most = static_cast<std::int64_t>(share_units * laws::surface_share);
  const auto most_driven = static_cast<std::int64_t>(share_units * laws::crowded_share) - 1;
  const Driven driven(cloth);
  auto n = work.new_particles;
  Kokkos::parallel_scan(
      "drench::emission::rank", range(cloth.samples.count),
      KOKKOS_LAMBDA(const Index c, Index& number, const bool last) {
        if (pools(c) == 0 || liquid(c) > (driven(c) ? most_driven : most)) return;
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

/// What a sample gives out: to the particle of its own pool, if it is a collector, and to its target's.
struct GiveOut {
  Entries<const Real3> position, leaving_velocity;
  Entries<const Quanta> total, rest, pools;
  Entries<const std::uint8_t> created;
  Entries<const Index> ranks, target;
  Neighbors list;
  Quanta full;
  SampleSolute solute;

  GiveOut(const NeighborLists& lists, EmissionWork& work, Quanta full_particle)
      : position(work.position),
        leaving_velocity(work.velocity),
        total(work.total),
        rest(work.rest),
        pools(work.pool),
        created(work.created),
        ranks(work.rank),
        target(work.target),
        list(lists.sample_sample),
        full(full_particle),
        solute(work) {}

  /// The particle of collector p: the mass of its pool, and its givers' momentum.
  KOKKOS_INLINE_FUNCTION Particle particle_of(Index p, std::int64_t first_id) const {
    Quanta mass = 0, dissolved = 0;
    double px = 0, py = 0, pz = 0;
    const auto add = [&](const Index g) {
      const Quanta part = pooled_part(rest(g), pools(p), full);
      mass += part;
      if (solute.exists()) dissolved += solute.of(g, part);
      px += double(part) * double(leaving_velocity(g).x);
      py += double(part) * double(leaving_velocity(g).y);
      pz += double(part) * double(leaving_velocity(g).z);
    };
    add(p);
    list.for_each(p, [&](Index q) {
      if (target(q) == p) add(q);
    });
    const double inverse = 1 / double(mass);
    Particle made;
    made.position = position(p);
    made.velocity = {Real(inverse * px), Real(inverse * py), Real(inverse * pz)};
    made.mass = mass;
    made.solute = dissolved;
    made.id = first_id + ranks(p);
    made.origin = static_cast<std::uint8_t>(Origin::cloth);
    return made;
  }
  /// What p gave to a new particle.
  KOKKOS_INLINE_FUNCTION Quanta given_to_new(Index p) const {
    const Index q = target(p);
    return q >= 0 && created(q) ? pooled_part(rest(p), pools(q), full) : 0;
  }
};

/// Appends the new particles (d), and finds out what each sample gave (e). The candidates' cells are empty again.
void give_out(const Constants& constants, Fluid& fluid, const NeighborLists& lists, Cloth& cloth, EmissionWork& work,
              Index new_particles) {
  ParticleSet& particles = fluid.particles;
  const Index first = particles.count;
  const bool here = fluid.exchange.alone() || fluid.exchange.ranks()->rank() == 0;  // they go home with the next search
  if (here && new_particles > 0) particles.reserve(first + new_particles);
  const ParticleView all = particles.view();
  const std::int64_t id = particles.next_id;
  const CandidateCells cells(cloth, work);
  const Entries<Quanta> given = work.given;
  const GiveOut give(lists, work, constants.model.max_quanta);
  const FacesOfNew faces(cloth);
  parallel(
      "drench::emission::give_out", cloth.samples.count, KOKKOS_LAMBDA(const Index p) {
        if (give.pools(p) > 0) cells.clear_cell_of(p);
        if (here && give.created(p)) all.store(first + give.ranks(p), give.particle_of(p, id));
        const Quanta pooled = give.given_to_new(p);
        given(p) = give.total(p) - give.rest(p) + pooled;
        if (pooled > 0) faces.count(p, give.position(give.target(p)), pooled);
        if (give.solute.exists()) give.solute.take(p, pooled);
      });
  if (here) particles.count = first + new_particles;
  particles.next_id += new_particles;
}

}  // namespace

void create_particles(const Constants& constants, Fluid& fluid, const NeighborLists& lists, Cloth& cloth,
                      EmissionWork& work) {
  prepare(cloth, work);
  target(constants, lists, cloth, work);
  pool(constants, lists, cloth, work);
  measure_space(constants, fluid, cloth, work);
  fluid.exchange.add_up(work.liquid, cloth.samples.count);
  rank(constants, cloth, work);
  exec().fence("drench::emission::counts");
  const EmissionCounts counts = work.counts();
  work.idle = counts.buffered == 0;
  if (counts.empty > 0) fluid.particles.compact({}, fluid.particles.count - counts.empty);
  give_out(constants, fluid, lists, cloth, work, work.new_particles());
}

}  // namespace drench::kokkos_backend
