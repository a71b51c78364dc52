#pragma once
// How liquid spreads within the cloth: paper Eq. 11, replaced as src/stages/diffusion.hpp says.

#include "core/types.hpp"

namespace drench::kokkos_backend::laws {

/// ψ, 1: the mean of sⁿ over the saturations between a and b, at most 2 s_donorⁿ, which is 0 of a dry donor. n is neither 0 nor 1.
KOKKOS_INLINE_FUNCTION double power_mobility(double a, double b, double donor, double n) {
  const double low = Kokkos::fmax(0.0, Kokkos::fmin(a, b)), high = Kokkos::fmax(0.0, Kokkos::fmax(a, b));
  const double most = 2 * Kokkos::pow(Kokkos::fmax(0.0, donor), n), middle = (low + high) / 2;
  if (high - low > 0.02 * middle)
    return Kokkos::fmin(most, (high * Kokkos::pow(high, n) - low * Kokkos::pow(low, n)) / ((n + 1) * (high - low)));
  if (!(middle > 0)) return 0;
  // The quotient would lose digits: its series about the middle, to below 1e-13 of it.
  const double square = (high - low) / (2 * middle) * ((high - low) / (2 * middle));
  const double series = 1 + n * (n - 1) / 6 * square * (1 + (n - 2) * (n - 3) / 20 * square);
  return Kokkos::fmin(most, Kokkos::pow(middle, n) * series);
}

/// F, kg/s, positive from j to i: G ψ [(s_j − s_i) + drop], drop = (x_i − x_j)·ĝ/ℓ (1), G in kg/s, for the exponent n.
KOKKOS_INLINE_FUNCTION double diffusion_flux(double conductance, double saturation_i, double saturation_j, double drop,
                                             double n) {
  const double drive = (saturation_j - saturation_i) + drop;
  if (n == 0) return conductance * drive;
  const double donor = drive > 0 ? saturation_j : saturation_i;
  if (n == 1) return conductance * Kokkos::fmin((saturation_i + saturation_j) / 2, 2 * donor) * drive;
  return conductance * power_mobility(saturation_i, saturation_j, donor, n) * drive;
}

/// The same for fabric that holds liquid by sᵝ: the drive is a difference of that, and sⁿ a power of it.
KOKKOS_INLINE_FUNCTION double retained_flux(double conductance, double saturation_i, double saturation_j, double drop, double n,
                                            double beta) {
  if (beta == 1) return diffusion_flux(conductance, saturation_i, saturation_j, drop, n);
  return diffusion_flux(conductance, Kokkos::pow(Kokkos::fmax(0.0, saturation_i), beta),
                        Kokkos::pow(Kokkos::fmax(0.0, saturation_j), beta), drop, n / beta);
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
