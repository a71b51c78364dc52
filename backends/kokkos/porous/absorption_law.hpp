#pragma once
// How much liquid cloth takes up: paper Eq. 7 in the form of src/stages/absorption.hpp.

#include "core/types.hpp"

namespace drench::kokkos_backend::laws {

/// cap_ij, 1: the saturation up to which sample j takes liquid that comes from where `cosine` says (1: from upstream; 0
/// and less: no more than 1).
KOKKOS_INLINE_FUNCTION Real saturation_cap(Real max_saturation, Real cosine) {
  return cosine > 0 ? 1 + (max_saturation - 1) * cosine : Real(1);
}

/// The same of fabric that carries a film: whatever touches its faces, except what hangs below it, can join the film.
KOKKOS_INLINE_FUNCTION Real film_cap(Real max_saturation, Real cosine) {
  return cosine > Real(-0.25) ? max_saturation : Real(1);
}

/// L, 1/m⁵: the viscosity kernel's Laplacian (Müller et al. 2003), 45 (h − r)/(π h⁶) ≥ 0.
KOKKOS_INLINE_FUNCTION double viscosity_laplacian(double r, double h) {
  constexpr double pi = 3.14159265358979323846;
  return r < h ? 45 * (h - r) / (pi * h * h * h * h * h * h) : 0;
}

/// Demand w_ij in the unit of `capacity` (Eq. 7): Δt k_a C_j deficit V_i L with k_a in m²/s, C_j in kg or quanta, V_i
/// in m³.
KOKKOS_INLINE_FUNCTION double absorption_demand(double dt, double absorption, double capacity, double deficit,
                                                double volume, double laplacian) {
  return dt * absorption * capacity * deficit * volume * laplacian;
}

/// T_i = m_i (1 − exp(−Σw/m_i)): what liquid of mass m_i gives in all, in the unit of mass and demand. Never more than
/// it has.
KOKKOS_INLINE_FUNCTION double absorption_total(double mass, double demand) {
  return -mass * Kokkos::expm1(-demand / mass);
}

}  // namespace drench::kokkos_backend::laws
