#pragma once
// Walls with the pressure that the liquid's gradient along them makes: docs/theory/walls_and_sheets.md, Eqs. 7a to 7d.

#include "bodies/bodies.hpp"
#include "core/constants.hpp"
#include "coupling/wall.hpp"
#include "particles/fluid.hpp"

namespace drench::kokkos_backend {

/// fluid.wall_gain of all particles; 1 where there are no walls.
void find_wall_gain(const Constants& constants, const NeighborLists& lists, const Bodies& bodies, Fluid& fluid);

/// The largest eigenvalue of a gain, or a little more: two of the three are at least 1.
KOKKOS_INLINE_FUNCTION Real largest_gain(const Real3& diagonal, const Real3& shear) {
  return Kokkos::sqrt(larger(dot(diagonal, diagonal) + 2 * dot(shear, shear) - 2, Real(1)));
}

}  // namespace drench::kokkos_backend
