#pragma once
// The discrete divergence of a velocity field over liquid, walls and cloth, and its adjoint. Both pressure solves are
// made of them: docs/theory/liquid.md, Eqs. 11 and 12; cloth: docs/theory/walls_and_sheets.md, Eq. 17a.

#include "core/neighbor_list.hpp"
#include "coupling/sheet_rows.hpp"
#include "coupling/wall.hpp"

namespace drench::kokkos_backend {

/// G_ij · v of a pair, 1/s; G_ij = factor · x.
KOKKOS_INLINE_FUNCTION Real pair_rate(Real factor, const Real3& v, const Real3& x) { return factor * dot(v, x); }

/// D and its adjoint over the pairs of stage density, with G_ij = V_j ∇W_ij. Velocities are functions of an index.
struct DensityOperator {
  Neighbors liquid, walls;
  Entries<const Real4> position;  // x_i, m; for the adjoint with κ_i, m²/s²
  Entries<const Real3> wall_position;
  SheetsOfParticles sheets;
  bool has_walls, has_sheets;

  /// Adds Σ_j G_ij · (v_i − v_j) over the liquid, 1/s. `Rate` is what pair_rate() makes of the velocities,
  /// which may be several at once.
  template <class Velocity, class OfLiquid, class Rate>
  KOKKOS_INLINE_FUNCTION void add_liquid(Index i, const Velocity& vi, const OfLiquid& v, Rate& sum) const {
    const Real3 xi = position(i).xyz();
    liquid.for_each(i, [&](Index j, Real factor) { sum += pair_rate(factor, vi - v(j), xi - position(j).xyz()); });
  }
  /// The same over the solids' samples, which stand for the mirrored liquid.
  template <class Velocity, class OfWalls, class Rate>
  KOKKOS_INLINE_FUNCTION void add_walls(Index i, const Velocity& vi, const OfWalls& u, Rate& sum) const {
    if (!has_walls) return;
    const Real3 xi = position(i).xyz();
    walls.for_each(
        i, [&](Index b, Real factor) { sum += pair_rate(mirrored * factor, vi - u(b), xi - wall_position(b)); });
  }
  /// Σ_n p_in · (v_i − u_n) over the cloth's nodes, 1/s: how fast the particle comes nearer to cloth.
  KOKKOS_INLINE_FUNCTION Real approach(Index i, const Real3& vi) const {
    return has_sheets ? sheets.approach(i, vi) : Real(0);
  }

  /// Σ_j G_ij (κ_i + κ_j) over the liquid, m/s². Walls and cloth have κ_i times a sum of the step
  /// (Fluid::boundary_gradient).
  KOKKOS_INLINE_FUNCTION Real3 gradient(Index i) const {
    const Real4 here = position(i);
    const Real3 xi = here.xyz();
    Real3 sum;
    liquid.for_each(i, [&](Index j, Real factor) {
      const Real4 at = position(j);
      sum += (factor * (here.w + at.w)) * (xi - at.xyz());
    });
    return sum;
  }
};

}  // namespace drench::kokkos_backend
