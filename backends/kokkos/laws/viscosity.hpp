#pragma once
// Viscosity of a pair; law and source in src/stages/forces.hpp.

#include "types.hpp"

namespace drench::kokkos_backend {

/// Factor of ∇W in the viscous acceleration of a pair, m⁴/s² : 10 ν V (v·x)/(r² + 0.01 h²).
/// `volume` is V_j over the mean density ratio (m³), `rv` = v_ij·x_ij (m²/s), `r2` = |x_ij|² (m²).
KOKKOS_INLINE_FUNCTION Real viscous_factor(Real viscosity, Real volume, Real rv, Real r2, Real h) {
  return 10 * viscosity * volume * rv / (r2 + Real(0.01) * h * h);
}

}  // namespace drench::kokkos_backend
