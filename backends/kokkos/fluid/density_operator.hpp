#pragma once
// The discrete divergence of a velocity field over liquid, walls and cloth, and its adjoint. Both pressure solves are
// made of them: docs/theory/liquid.md, Eqs. 11 and 12; cloth: docs/theory/walls_and_sheets.md, Eq. 17a.

#include "core/liquid_pairs.hpp"
#include "core/quads.hpp"
#include "coupling/sheet_rows.hpp"
#include "coupling/wall.hpp"

namespace drench::kokkos_backend {

/// G_ij · v of a pair, 1/s; G_ij = factor · x.
KOKKOS_INLINE_FUNCTION Real pair_rate(Real factor, const Real3& v, const Real3& x) { return factor * fused_dot(v, x); }

/// D and its adjoint over the pairs of stage density, with G_ij = V_j ∇W_ij. Velocities are functions of an index.
struct DensityOperator {
  LiquidPairs liquid;
  Neighbors walls;
  Entries<const Real4> position;  // x_i, m; for the adjoint with κ_i, m²/s²
  Entries<const Real3> wall_position;
  SheetsOfParticles sheets;
  bool has_walls, has_sheets;

  /// Adds Σ_j G_ij · (v_i − v_j) over the liquid, 1/s. `Rate` is what pair_rate() makes of the velocities,
  /// which may be several at once.
  template <class Velocity, class OfLiquid, class Rate>
  KOKKOS_INLINE_FUNCTION void add_liquid(Index i, const Velocity& vi, const OfLiquid& v, Rate& sum) const {
    liquid.for_each_or_self(i, position, [&](Index j, const Real4&, const Real3& r, Real factor) {
      sum += pair_rate(factor, vi - v(j), r);
    });
  }
  /// The same with the velocities of one array.
  KOKKOS_INLINE_FUNCTION void add_liquid(Index i, const Entries<const Real4>& v, Real& sum) const {
#ifdef DRENCH_LANES
    const Quad xi = quad(position(i)), vi = quad(v(i));
    const Quad rates = sum_of_quads(
        liquid.row(i), [&](Index j, Real factor) { return factor * ((vi - quad(v(j))) * (xi - quad(position(j)))); });
    sum += rates[0] + rates[1] + rates[2];
#else
    add_liquid(
        i, v(i).xyz(), [&](Index j) { return v(j).xyz(); }, sum);
#endif
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
  /// (Fluid::boundary_gradient). Of `lanes` threads that share a particle each has its own part of the sum.
  template <Index lanes = 1>
  KOKKOS_INLINE_FUNCTION Real3 gradient(Index i, [[maybe_unused]] Index lane = 0) const {
#ifdef DRENCH_LANES
    const Real4 here = position(i);
    const Quad from = quad({here.xyz(), -here.w});
    const Quad sum = sum_of_quads(liquid.row(i), [&](Index j, Real factor) {
      const Quad apart = from - quad(position(j));  // and −(κ_i + κ_j)
      return (-factor * apart[3]) * apart;
    });
    return {sum[0], sum[1], sum[2]};
#else
    const Real kappa = position(i).w;
    Real3 sum;
    liquid.for_each_or_self<lanes>(
        i, position,
        [&](Index, const Real4& at, const Real3& r, Real factor) { sum = fused_sum(sum, factor * (kappa + at.w), r); },
        lane);
    return sum;
#endif
  }
};

}  // namespace drench::kokkos_backend
