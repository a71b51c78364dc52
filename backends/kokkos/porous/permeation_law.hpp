#pragma once
// How pressure drives liquid through wet cloth: Darcy's law in the form of src/stages/permeation.hpp.

#include "core/types.hpp"

namespace drench::kokkos_backend::laws {

/// Σ V W of one side of a sheet, 1: below the first the rest of that side counts as air, above the second it is covered.
inline constexpr double full_side = 0.1, covered_side = 0.25;

/// φ_i, m²/s²: the potential p/ρ0 of liquid with κ in m²/s², carried `away` (m) from it to the sheet; never below 0.
KOKKOS_INLINE_FUNCTION Real carried_potential(Real kappa, const Real3& gravity, const Real3& away) {
  const Real potential = kappa - dot(gravity, away);
  return potential > 0 ? potential : Real(0);
}

/// φ of one side, m²/s², of Σ V W and Σ V W φ_i.
KOKKOS_INLINE_FUNCTION double side_potential(double filled, double sum, double in_air) {
  return filled < full_side ? (sum + (full_side - filled) * in_air) / full_side : sum / filled;
}

/// k_r, 1: the part of its permeability that a sheet has at a saturation (Brooks and Corey 1964, pores of one size).
KOKKOS_INLINE_FUNCTION Real relative_permeability(Real saturation) {
  return saturation < 1 ? saturation * saturation * saturation : Real(1);
}

}  // namespace drench::kokkos_backend::laws
