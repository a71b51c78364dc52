#pragma once
// How liquid spreads within the cloth: paper Eq. 11, replaced as src/stages/diffusion.hpp says.

#include "types.hpp"

namespace drench::kokkos_backend::laws {

/// κ_ij = 1 − r/h, 1.
KOKKOS_INLINE_FUNCTION Real diffusion_weight(Real r, Real support) { return 1 - r / support; }

/// G_ij, kg/s: 4 D ½(C_i a_j + C_j a_i) κ/M2 with D in m²/s, C in kg, a in m², M2 in m⁴; 0 if M2 = 0.
KOKKOS_INLINE_FUNCTION Real conductance(Real diffusivity, Real capacity_i, Real area_i, Real capacity_j, Real area_j,
                                        Real weight, Real moment) {
  if (!(moment > 0)) return 0;
  return 4 * diffusivity * (capacity_i * area_j + capacity_j * area_i) / 2 * (weight / moment);
}

/// F_ij, kg/s, positive from j to i: G [σ_ij (s_j − s_i) + σ_up drop], drop = (x_i − x_j)·ĝ/ℓ.
/// Linear law: σ = 1. Degenerate law (the paper's factor m_f): σ_ij = ½(s_i + s_j), σ_up = s where the gravity term
/// comes from.
KOKKOS_INLINE_FUNCTION Real diffusion_flux(Real conductance_ij, Real saturation_i, Real saturation_j, Real drop,
                                           bool degenerate) {
  const Real mean = degenerate ? (saturation_i + saturation_j) / 2 : Real(1);
  const Real upwind = degenerate ? (drop > 0 ? saturation_j : saturation_i) : Real(1);
  return conductance_ij * (mean * (saturation_j - saturation_i) + upwind * drop);
}

/// One pair's part of rate_i, 1/s: how fast it can empty a sample of capacity C_i (kg).
KOKKOS_INLINE_FUNCTION Real diffusion_rate(Real conductance_ij, Real drop, Real capacity_i) {
  return capacity_i > 0 ? conductance_ij * (1 + Kokkos::abs(drop)) / capacity_i : Real(0);
}

}  // namespace drench::kokkos_backend::laws
