#pragma once
// How a node slips on a solid (docs/theory/cloth.md, section 8).

#include "cloth/solver.hpp"

namespace drench::kokkos_backend {

/// The slip so far, and y = slip + r_t/D that it would come to without friction, by the rule of the residual's test.
struct Slip {
  Double3 so_far, on, whole;  // m; r_t, N; y, m
  double length, loss;        // |y|, and how much of it friction takes, m

  /// `relative`: the displacement less that of the surface, m, and `on`: the residual, N, both along the directions
  /// that the solids leave; `press`: what presses the node into them, N.
  KOKKOS_INLINE_FUNCTION Slip(const NodeTerms& t, const Double3& relative, const Double3& along, double press)
      : so_far(relative),
        on(along),
        whole(so_far + (1 / double(t.diagonal)) * on),
        length(norm(whole)),
        loss(double(t.friction) * press / double(t.diagonal)) {}
};

}  // namespace drench::kokkos_backend
