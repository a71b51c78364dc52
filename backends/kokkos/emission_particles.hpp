#pragma once
// Stage emission (src/stages/emission.hpp), part (d): new particles. Also what (c) and (d) share.

#include "laws/flow.hpp"
#include "primitives/transfer.hpp"

namespace drench::kokkos_backend {

/// Which samples see which: what (c) and (d) ask about a pair of samples.
struct Layers {
  Array<Index> cloth;
  Array<Real3> rest;
  Real support;

  KOKKOS_INLINE_FUNCTION bool same(Index p, Index q) const {
    return cloth(p) == cloth(q) && !laws::folded_apart(rest(p) - rest(q), support);
  }
};

inline Layers layers_of(const Device& d) { return {d.samples.cloth, d.samples.rest_position, d.support}; }

/// Quanta that a giver puts into a collector's pool of `sum`: all that it has left, cut if the pool is more than a full
/// particle.
KOKKOS_INLINE_FUNCTION Quanta pooled_part(Quanta rest, Quanta sum, Quanta full) {
  return sum <= full ? rest : floor_ratio(rest, full, sum);
}

/// (d): pools what is left (emission_work.rest), and appends a liquid particle for each pool that is large enough and
/// has space. Returns how many; emission_work.target, .pool, .candidate and .created then say who gave (.created only
/// if there were candidates).
Index create_particles(Device& d);

}  // namespace drench::kokkos_backend
