#pragma once
// The liquid's pairs with the samples of sheets, summed up to pairs with nodes once a step: an iteration of the
// pressure reads a third of the pairs, and no samples. Law: docs/theory/walls_and_sheets.md, Eq. 17a.

#include "cloth/cloth.hpp"
#include "particles/fluid.hpp"

namespace drench::kokkos_backend {

/// lists.sheet_rows of the particles, samples and density ratios as they are. Synchronises with the host.
void make_sheet_rows(const Constants& constants, const Fluid& fluid, const Cloth& cloth, NeighborLists& lists);

/// The rows of particles as kernels see them, with the nodes' velocities, `scale` × `node`.
struct SheetsOfParticles {
  Entries<const Index> start;
  Entries<const SheetPair> pair;
  Entries<const Real3> node;
  Real scale;

  /// Σ_n p_in · (v − u_n), 1/s.
  KOKKOS_INLINE_FUNCTION Real approach(Index i, const Real3& v) const {
    Real sum = 0;
    const Index last = start(i + 1);
    DRENCH_UNROLL
    for (Index e = start(i); e < last; ++e) {
      const SheetPair near = pair(e);
      sum += dot(near.gradient, v - scale * node(near.other));
    }
    return sum;
  }
};

/// What `check` counts for them.
double sheet_row_bytes(const Sizing& s);

}  // namespace drench::kokkos_backend
