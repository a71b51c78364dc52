#pragma once
// How liquid spreads within the cloth: paper Eq. 11, replaced as src/stages/diffusion.hpp says.

#include "cloth/retention_law.hpp"
#include "core/types.hpp"

namespace drench::kokkos_backend::laws {

/// ψ, 1: the mean of sⁿ over the saturations between a and b, at most 2 s_donorⁿ, which is 0 of a dry donor. n is
/// neither 0 nor 1.
KOKKOS_INLINE_FUNCTION double power_mobility(double a, double b, double donor, double n) {
  const double low = larger(0.0, smaller(a, b)), high = larger(0.0, larger(a, b));
  const double most = 2 * Kokkos::pow(larger(0.0, donor), n), middle = (low + high) / 2;
  if (high - low > 0.02 * middle)
    return smaller(most, (high * Kokkos::pow(high, n) - low * Kokkos::pow(low, n)) / ((n + 1) * (high - low)));
  if (!(middle > 0)) return 0;
  // The quotient would lose digits: its series about the middle, to below 1e-13 of it.
  const double square = (high - low) / (2 * middle) * ((high - low) / (2 * middle));
  const double series = 1 + n * (n - 1) / 6 * square * (1 + (n - 2) * (n - 3) / 20 * square);
  return smaller(most, Kokkos::pow(middle, n) * series);
}

/// ψ for any n ≥ 0.
KOKKOS_INLINE_FUNCTION double mobility(double a, double b, double donor, double n) {
  if (n == 0) return 1;
  if (n == 1) return smaller((a + b) / 2, 2 * donor);
  return power_mobility(a, b, donor, n);
}

/// ψ of small and large pores side by side (docs/theory/porous.md, Eq. 51); `donor`: the filling of the node that
/// gives.
KOKKOS_INLINE_FUNCTION double parallel_mobility(const PoreCurve& curve, const PoreFilling& a, const PoreFilling& b,
                                                const PoreFilling& donor, double n) {
  const double w = curve.large, wide = curve.narrowing * curve.narrowing;
  return (1 - w) * mobility(a.small, b.small, donor.small, n) + w * wide * mobility(a.large, b.large, donor.large, n);
}

/// F, kg/s, positive from j to i: G ψ (held_j − held_i + drop), held = 1 − h/ℓ of the suction h, drop = (x_i − x_j)·ĝ/ℓ
/// (1), G in kg/s, for the exponent n.
KOKKOS_INLINE_FUNCTION double held_flux(double conductance, double saturation_i, double saturation_j, double held_i,
                                        double held_j, double drop, double n) {
  const double drive = (held_j - held_i) + drop;
  return conductance * mobility(saturation_i, saturation_j, drive > 0 ? saturation_j : saturation_i, n) * drive;
}

/// The same for fabric that holds liquid by s.
KOKKOS_INLINE_FUNCTION double diffusion_flux(double conductance, double saturation_i, double saturation_j, double drop,
                                             double n) {
  return held_flux(conductance, saturation_i, saturation_j, saturation_i, saturation_j, drop, n);
}

/// The same by sᵝ: the drive is a difference of that, and sⁿ a power of it.
KOKKOS_INLINE_FUNCTION double retained_flux(double conductance, double saturation_i, double saturation_j, double drop,
                                            double n, double beta) {
  if (beta == 1) return diffusion_flux(conductance, saturation_i, saturation_j, drop, n);
  return diffusion_flux(conductance, Kokkos::pow(larger(0.0, saturation_i), beta),
                        Kokkos::pow(larger(0.0, saturation_j), beta), drop, n / beta);
}

/// F, kg/s, of a film on both faces that runs down by `drop` (m) from where it is δ thick, m (docs/theory/porous.md,
/// Eq. 39); `flow` is ω ρ0 |g|/(12 ν).
KOKKOS_INLINE_FUNCTION double film_flux(double flow, double delta, double drop) {
  return delta > 0 ? flow * delta * delta * delta * drop : 0;
}
/// What it grows by with the saturation of the node that it leaves, kg/s, with a film of `most` on both faces.
KOKKOS_INLINE_FUNCTION double steepest_film(double flow, double most, double depth, double drop) {
  return flow * 3 * most * most * depth * Kokkos::abs(drop);
}

/// One of two layers in contact.
struct Layer {
  double load, thickness, diffusivity;  // ρ0 (1−Φ) τ in kg/m²; m; m²/s
  double height, retention;             // r = ℓ over the lesser ℓ of both; β
  double steepest;  // the most that its suction over the lesser ℓ falls by with s; 1 for β below 1

  /// What its suction over the lesser ℓ falls by in filling up: r sᵝ.
  KOKKOS_INLINE_FUNCTION double held(double saturation) const {
    return height * (retention == 1 ? saturation : Kokkos::pow(larger(0.0, saturation), retention));
  }
};

/// K, kg/(m² s): half of each of two layers in series. At most what a quarter of the lighter layer's load would need in
/// Δt.
KOKKOS_INLINE_FUNCTION double contact_conductance(const Layer& p, const Layer& t, double dt) {
  const double resistance = p.height * (p.thickness * p.thickness) / (2 * p.load * p.diffusivity) +
                            t.height * (t.thickness * t.thickness) / (2 * t.load * t.diffusivity);
  return smaller(1 / resistance, smaller(p.load / p.steepest, t.load / t.steepest) / (4 * dt));
}

}  // namespace drench::kokkos_backend::laws
