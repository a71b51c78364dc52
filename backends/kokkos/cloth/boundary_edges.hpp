#pragma once
// Where a sheet ends (src/stages/neighbors.hpp).

#include "cloth/cloth.hpp"

namespace drench::kokkos_backend {

/// The boundary edge loops of the cloths' meshes, where they are now; `near` is empty where there is none.
struct BoundaryEdges {
  Entries<const Index> near;  // 2 per sample: boundary edges, −1: none
  Entries<const Index> edge;  // 3 per edge: its nodes and the third one of its triangle
  Entries<const Real3> node;  // m

  explicit BoundaryEdges(const Cloth& cloth)
      : near(cloth.samples.boundary_edge), edge(cloth.mesh.boundary_edge), node(cloth.nodes.position) {}

  /// Whether c (m), in the plane of sample p, is beyond the boundary of its sheet.
  KOKKOS_INLINE_FUNCTION bool beyond(Index p, const Real3& c) const {
    Real least = 0, side = 0;
    Index shared = -1;
    Real3 outward{0, 0, 0};
    for (int k = 0; k < 2; ++k) {
      const Index e = near(2 * p + k);
      if (e < 0) break;  // the first is there if the second is
      const Index from = edge(3 * e), to = edge(3 * e + 1);
      const Real3 a = node(from), along = node(to) - a, inward = node(edge(3 * e + 2)) - a, r = c - a;
      const Real square = dot(along, along), where = dot(r, along) / square;
      Real3 m = (dot(inward, along) / square) * along - inward;
      m = (1 / Kokkos::sqrt(dot(m, m))) * m;
      const Index corner = where <= 0 ? from : where >= 1 ? to : -1;
      const Real3 gap = r - smaller(larger(where, Real(0)), Real(1)) * along;
      const Real distance = dot(gap, gap);
      if (k == 1 && corner >= 0 && corner == shared) return dot(c - node(corner), m + outward) > 0;
      if (k == 0 || distance < least) {
        least = distance;
        side = dot(r, m);
      }
      shared = corner;
      outward = m;
    }
    return side > 0;
  }

  /// Whether xp + c, in the plane of sample p at xp, is on its sheet near the sample; square: (1.25 d)².
  KOKKOS_INLINE_FUNCTION bool on_sheet(Index p, const Real3& xp, const Real3& c, Real square) const {
    return dot(c, c) < square && !(near.exist() && beyond(p, xp + c));
  }
};

}  // namespace drench::kokkos_backend
