#pragma once
// How pressure drives liquid through wet cloth: Darcy's law in the form of src/stages/permeation.hpp.

#include "core/types.hpp"

namespace drench::kokkos_backend::laws {

/// Σ V W of one side of a sheet, 1: below the first the rest of that side counts as air, above the second it is
/// covered.
inline constexpr double full_side = 0.1, covered_side = 0.25;

/// A particle that pressure drains is taken whole where less than this part of m_min would remain.
inline constexpr Quanta drained_part = 16;

/// How much of a side counts as air, 1.
KOKKOS_INLINE_FUNCTION double air_share(double filled) { return filled < full_side ? 1 - filled / full_side : 0; }

/// What a sample feels of the liquid around it: where its normal leaves, and where it points.
struct Surroundings {
  double filled[2], potential[2];  // Σ V W, 1; Σ V W φ, m²/s²
  double load;                     // m²/s², along the normal
  double at_walls;                 // how close extrapolated walls are, 0 to 1

  /// How far both sides are covered, 0 to 1.
  KOKKOS_INLINE_FUNCTION double covered() const {
    const double less = filled[0] < filled[1] ? filled[0] : filled[1];
    return less <= full_side ? 0 : less < covered_side ? (less - full_side) / (covered_side - full_side) : 1;
  }
  /// The mean potential of a side as far as it is liquid, m²/s².
  KOKKOS_INLINE_FUNCTION double mean_potential(int side) const {
    return filled[side] > 0 ? (1 - air_share(filled[side])) * potential[side] / filled[side] : 0;
  }
  /// What drives liquid along the normal, m²/s²: the load where one side is free, the difference of potentials where
  /// both are covered or walls carry a part of the load. `weight` is gravity along the normal times half of the
  /// thickness.
  KOKKOS_INLINE_FUNCTION double drive(double weight) const {
    const double share = Kokkos::fmax(covered(), at_walls);
    const double pressure = share > 0 ? share * (mean_potential(0) - mean_potential(1)) : 0;
    return (1 - share) * load + pressure + weight * (air_share(filled[0]) + air_share(filled[1]));
  }
};

/// What of a flux is beyond `unresolved`, both in m/s.
KOKKOS_INLINE_FUNCTION double beyond(double flux, double unresolved) {
  return flux > unresolved ? flux - unresolved : flux < -unresolved ? flux + unresolved : 0;
}

/// Is a flux (m/s) beyond what the breakthrough pressure holds back?
KOKKOS_INLINE_FUNCTION bool is_open(Real flux, Real conductance, Real entry_potential) {
  return Kokkos::fabs(flux) > conductance * entry_potential;
}

/// k_r, 1: the part of its permeability that a sheet has at a saturation (Brooks and Corey 1964, pores of one size).
KOKKOS_INLINE_FUNCTION Real relative_permeability(Real saturation) {
  return saturation < 1 ? saturation * saturation * saturation : Real(1);
}

}  // namespace drench::kokkos_backend::laws
