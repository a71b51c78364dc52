#pragma once
// How liquid spreads within the cloth: paper Eq. 11, replaced as src/stages/diffusion.hpp says.

#include "core/types.hpp"

namespace drench::kokkos_backend::laws {

/// F, kg/s, positive from j to i: G σ [(s_j − s_i) + drop], drop = (x_i − x_j)·ĝ/ℓ (1), G in kg/s.
/// Linear law: σ = 1. Degenerate law (the paper's factor m_f): σ = min(½ (s_i + s_j), 2 s_donor).
KOKKOS_INLINE_FUNCTION double diffusion_flux(double conductance, double saturation_i, double saturation_j, double drop,
                                             bool degenerate) {
  const double drive = (saturation_j - saturation_i) + drop;
  if (!degenerate) return conductance * drive;
  const double donor = drive > 0 ? saturation_j : saturation_i;
  return conductance * Kokkos::fmin((saturation_i + saturation_j) / 2, 2 * donor) * drive;
}

/// K, kg/(m² s): half of each of two layers in series; `load` = ρ0 (1−Φ) τ in kg/m², τ in m, D in m²/s. At most
/// ¼ min(load)/Δt.
KOKKOS_INLINE_FUNCTION double contact_conductance(double load_p, double thickness_p, double diffusivity_p,
                                                  double load_t, double thickness_t, double diffusivity_t, double dt) {
  const double resistance = thickness_p * thickness_p / (2 * load_p * diffusivity_p) +
                            thickness_t * thickness_t / (2 * load_t * diffusivity_t);
  return Kokkos::fmin(1 / resistance, Kokkos::fmin(load_p, load_t) / (4 * dt));
}

}  // namespace drench::kokkos_backend::laws
