#pragma once
// How pressure drives liquid through wet cloth: Darcy's law in the form of src/stages/permeation.hpp.

#include "cloth/cloth.hpp"

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
    const double share = larger(covered(), at_walls);
    const double pressure = share > 0 ? share * (mean_potential(0) - mean_potential(1)) : 0;
    return (1 - share) * load + pressure + weight * (air_share(filled[0]) + air_share(filled[1]));
  }
};

/// u (m/s) that a difference of potentials (m²/s²) drives through a sheet: Darcy's law, with Forchheimer's term.
KOKKOS_INLINE_FUNCTION double flux_of(const Material& m, double drive) {
  const double darcy = double(m.conductance) * drive;
  if (!(m.inertial_loss > 0)) return darcy;
  return 2 * darcy / (1 + Kokkos::sqrt(1 + 4 * double(m.inertial_loss) * double(m.conductance) * Kokkos::abs(darcy)));
}
/// The difference of potentials (m²/s²) that drives |u|.
KOKKOS_INLINE_FUNCTION double drive_of(const Material& m, double flux) {
  const double u = Kokkos::abs(flux);
  return u / double(m.conductance) + double(m.inertial_loss) * u * u;
}

/// What of a flux (m/s) a difference of potentials drives that is less by `unresolved` (m²/s²).
KOKKOS_INLINE_FUNCTION double beyond(const Material& m, double flux, double unresolved) {
  if (m.inertial_loss > 0) {
    const double rest = flux_of(m, larger(0.0, drive_of(m, flux) - unresolved));
    return flux < 0 ? -rest : rest;
  }
  const double held = double(m.conductance) * unresolved;
  return flux > held ? flux - held : flux < -held ? flux + held : 0;
}

/// Is a flux (m/s) beyond what the breakthrough pressure holds back?
KOKKOS_INLINE_FUNCTION bool is_open(Real flux, const Material& m) {
  return Kokkos::fabs(flux) > Real(flux_of(m, double(m.entry_potential)));
}

/// k_r, 1: the part of its permeability that a sheet has at a saturation (Brooks and Corey 1964, pores of one size).
KOKKOS_INLINE_FUNCTION Real relative_permeability(Real saturation) {
  return saturation < 1 ? saturation * saturation * saturation : Real(1);
}

}  // namespace drench::kokkos_backend::laws
