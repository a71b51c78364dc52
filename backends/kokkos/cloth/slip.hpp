#pragma once
// How a node slips on a solid (docs/theory/cloth.md, section 8).

#include "cloth/solver.hpp"

namespace drench::kokkos_backend {

/// The slip so far, and y = slip + r_t/D that it would come to without friction, by the rule of the residual's test.
struct Slip {
  Double3 so_far, on, whole;  // m; r_t, N; y, m
  double length, loss;        // |y|, and how much of it friction takes, m

  /// `moved`: of the surface in the step, m; `left`: the residual, N; `press`: what presses the node into the solid, N.
  Slip(const NodeTerms& t, const Double3& normal, const Double3& shift, const Double3& moved, const Double3& left, double press)
      : so_far(ClothSystem::tangential(shift - moved, normal)),
        on(ClothSystem::tangential(left, normal)),
        whole(so_far + (1 / double(t.diagonal)) * on),
        length(norm(whole)),
        loss(double(t.friction) * press / double(t.diagonal)) {}
};

}  // namespace drench::kokkos_backend
