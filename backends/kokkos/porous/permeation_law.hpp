#pragma once
// How pressure drives liquid through wet cloth: Darcy's law in the form of src/stages/permeation.hpp.

#include "core/types.hpp"

namespace drench::kokkos_backend::laws {

/// Σ V W of one side of a sheet, 1: below the first the rest of that side counts as air, above the second it is covered.
inline constexpr double full_side = 0.1, covered_side = 0.25;

/// A particle that pressure drains is taken whole where less than this part of m_min would remain.
inline constexpr Quanta drained_part = 16;

/// How much of a side counts as air, 1.
KOKKOS_INLINE_FUNCTION double air_share(double filled) { return filled < full_side ? 1 - filled / full_side : 0; }

/// k_r, 1: the part of its permeability that a sheet has at a saturation (Brooks and Corey 1964, pores of one size).
KOKKOS_INLINE_FUNCTION Real relative_permeability(Real saturation) {
  return saturation < 1 ? saturation * saturation * saturation : Real(1);
}

}  // namespace drench::kokkos_backend::laws
