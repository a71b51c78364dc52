#pragma once
// Stage emission (src/stages/emission.hpp), parts (d), new particles, and (e), what leaves the nodes. Also what the
// parts share.

#include "porous/emission_law.hpp"
#include "porous/flow_law.hpp"
#include "porous/permeation_law.hpp"
#include "porous/stages.hpp"
#include "porous/transfer.hpp"

namespace drench::kokkos_backend {

/// Which samples see which: what (c) and (d) ask about a pair of samples.
struct Layers {
  Entries<const Index> cloth;
  Entries<const Real3> rest;
  Real support;

  KOKKOS_INLINE_FUNCTION bool same(Index p, Index q) const {
    return cloth(p) == cloth(q) && !laws::folded_apart(rest(p) - rest(q), support);
  }
};

/// e_p, where liquid leaves the samples: their flow direction itself in scenes without solids.
inline Entries<const Real3> leaving_directions(const Cloth& cloth, const EmissionWork& work) {
  if (work.direction.exists()) return work.direction;
  return cloth.samples.flow_direction;
}

/// Samples that pressure drives liquid through (stage permeation); none without permeable cloth.
struct Driven {
  Entries<const Real> passing;
  Materials materials;
  explicit Driven(const Cloth& cloth) : passing(cloth.samples.passing), materials(sample_materials(cloth)) {}
  KOKKOS_INLINE_FUNCTION bool operator()(Index p) const {
    return passing.exist() && laws::is_open(passing(p), materials(p));
  }
};

inline Layers layers_of(const Constants& constants, const Cloth& cloth) {
  return {cloth.samples.cloth, cloth.samples.rest_position, constants.support};
}

/// What of a node's liquid is buffered now, and the shares of its samples in that.
struct Maturing {
  Entries<const Quanta> capacity;
  Entries<const double> holds;  // C_n, kg
  Entries<const Index> sample_start, sample_item;
  Entries<const Real> film_pull;  // empty without films
  Entries<Quanta> liquid, buffered;
  Materials materials;
  Driven driven;
  double dt, spacing, quantum;

  Maturing(const Constants& constants, Cloth& fabric, double step)
      : capacity(fabric.nodes.capacity_quanta),
        holds(fabric.nodes.capacity),
        sample_start(fabric.nodes.sample_start),
        sample_item(fabric.nodes.sample_item),
        film_pull(fabric.nodes.film_pull),
        liquid(fabric.nodes.liquid),
        buffered(fabric.nodes.buffered),
        materials(node_materials(fabric)),
        driven(fabric),
        dt(step),
        spacing(constants.spacing),
        quantum(constants.quantum) {}

  /// May there be any?
  KOKKOS_INLINE_FUNCTION bool any(Index n) const { return buffered(n) > 0 || liquid(n) > capacity(n); }
  KOKKOS_INLINE_FUNCTION Quanta operator()(Index n) const {
    const Quanta excess = liquid(n) > capacity(n) ? liquid(n) - capacity(n) : 0;
    const Quanta kept = buffered(n) < excess ? buffered(n) : excess;
    if (kept == excess) return kept;
    const Material& m = materials(n);
    double velocity = m.emission_velocity;
    if (film_pull.exist() && m.film_depth > 0) {
      if (passes(n)) return excess;
      const double h = double(m.film_depth) * (double(excess - kept) * quantum / holds(n)) / 2;
      velocity = laws::film_velocity(velocity, double(m.film_growth), film_pull(n), h, spacing);
    }
    const double part = laws::maturing(velocity, dt, spacing);
    return kept + static_cast<Quanta>(Kokkos::floor(part * double(excess - kept)));
  }

 private:
  /// Does pressure drive liquid through a sample at node n?
  KOKKOS_INLINE_FUNCTION bool passes(Index n) const {
    if (!driven.passing.exist()) return false;
    for (Index k = sample_start(n); k < sample_start(n + 1); ++k)
      if (driven(sample_item(k) / 4)) return true;
    return false;
  }
};

/// The solute of what samples give out; empty without one.
struct SampleSolute {
  Entries<const Quanta> mass, total;  // E_p, and its solute
  Entries<Quanta> rest;

  explicit SampleSolute(EmissionWork& work)
      : mass(std::as_const(work).total), total(std::as_const(work).solute_total), rest(work.solute_rest) {}
  KOKKOS_INLINE_FUNCTION bool exists() const { return rest.exist(); }
  /// Of `liquid` quanta of E_p.
  KOKKOS_INLINE_FUNCTION Quanta of(Index p, Quanta liquid) const { return solute_part(total(p), liquid, mass(p)); }
  /// The same, which leaves.
  KOKKOS_INLINE_FUNCTION Quanta take(Index p, Quanta liquid) const {
    const Quanta part = of(p, liquid);
    if (part > 0) Kokkos::atomic_add(&rest(p), -part);
    return part;
  }
};

/// Quanta that a giver puts into a collector's pool of `sum`: all that it has left, cut if the pool is more than a full
/// particle.
KOKKOS_INLINE_FUNCTION Quanta pooled_part(Quanta rest, Quanta sum, Quanta full) {
  return sum <= full ? rest : floor_ratio(rest, full, sum);
}

/// Candidates by the cells of samples: a list a cell, in no particular order. A candidate or a place beyond the
/// samples' bounds counts to the cell at their boundary.
struct CandidateCells {
  CellGeometry cells;
  Entries<Index> head, next;
  Entries<const Real3> position;

  explicit CandidateCells(const Cloth& cloth, EmissionWork& work)
      : cells(static_cast<const CellGeometry&>(cloth.sample_cells.view())),
        head(work.head),
        next(work.next),
        position(work.position) {}

  KOKKOS_INLINE_FUNCTION static int within(int c, int dim) { return c < 0 ? 0 : c >= dim ? dim - 1 : c; }
  KOKKOS_INLINE_FUNCTION CellCoord inside(const CellCoord& c) const {
    if (cells.hashed) return c;
    return {within(c.x, cells.dims.x), within(c.y, cells.dims.y), within(c.z, cells.dims.z)};
  }
  KOKKOS_INLINE_FUNCTION Index bucket_of(const Real3& x) const { return cells.bucket_of(inside(cells.cell_of(x))); }
  KOKKOS_INLINE_FUNCTION void insert(Index c) const {
    next(c) = Kokkos::atomic_exchange(&head(bucket_of(position(c))), c);
  }
  KOKKOS_INLINE_FUNCTION void clear_cell_of(Index c) const { head(bucket_of(position(c))) = -1; }
  /// Calls visit(c) for every candidate in the 27 cells around x: all within h are among them.
  template <class Visit>
  KOKKOS_INLINE_FUNCTION void for_near(const Real3& x, Visit&& visit) const {
    const CellCoord at = cells.cell_of(x);
    const CellCoord lo = inside({at.x - 1, at.y - 1, at.z - 1}), hi = inside({at.x + 1, at.y + 1, at.z + 1});
    for (int cz = lo.z; cz <= hi.z; ++cz)
      for (int cy = lo.y; cy <= hi.y; ++cy)
        for (int cx = lo.x; cx <= hi.x; ++cx)
          for (Index c = head(cells.bucket_of({cx, cy, cz})); c >= 0; c = next(c))
            if (!cells.hashed || cells.cell_of(position(c)) == CellCoord{cx, cy, cz}) visit(c);
  }
};

/// Of the candidates' part.
MemoryEstimate candidate_bytes(const Sizing& s);

/// (d): pools what is left (emission_work.rest), removes liquid without mass, and appends a particle for each pool that
/// is large enough and has space; emission_work.given becomes what each sample gave in all. The host waits for the
/// number of both.
void create_particles(const Constants& constants, Fluid& fluid, const NeighborLists& lists, Cloth& cloth,
                      EmissionWork& work);

/// The part of the nodes' solute that goes with E_pk, and of samples with E_p.
void share_solute(const Cloth& cloth, EmissionWork& work);
/// (e) of the solute, before the liquid's: the rest of a sample's stays on its nodes.
void leave_solute(Cloth& cloth, TransferWork& transfers, EmissionWork& work);
/// (e): what each sample gave leaves its nodes; then what reaches them from other layers (c) arrives.
void leave(const Constants& constants, Cloth& cloth, TransferWork& transfers, EmissionWork& work, double dt);

}  // namespace drench::kokkos_backend
