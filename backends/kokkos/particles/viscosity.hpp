#pragma once
// Viscosity of a pair; law and source in src/stages/forces.hpp.

#include "core/constants.hpp"
#include "scene/scene.hpp"

namespace drench::kokkos_backend {

/// χ, 1: makes (χ ν/h²) Σ V (v·x) ∇W the ν Δv of the continuum.
inline Real viscosity_normalisation(KernelKind kind) {
  if (kind == KernelKind::wendland) return 30;
  if (kind == KernelKind::poly6) return 28;
  return Real(80.0 / 3);
}

/// χ ν/h², 1/s.
inline Real viscous_strength(const Constants& c) {
  const Model& m = c.model;
  return Real(viscosity_normalisation(m.scene.fluid.kernel) * m.scene.fluid.viscosity / (m.support * m.support));
}

/// δ_i as viscosity counts it.
KOKKOS_INLINE_FUNCTION Real bounded_ratio(Real delta) { return delta < Real(0.5) ? Real(0.5) : delta; }

constexpr Real solid_friction = 2;           // samples half a spacing behind the surface
constexpr Real sheet_friction = Real(0.57);  // samples on the sheet

/// Viscous pulls on a particle, summed up; times χ ν/h² they are an acceleration (m/s²) and its bound C (1/s).
struct ViscousSum {
  Real3 pull;      // m³/s
  Real bound = 0;  // m²
  /// A partner at r = x_i − x_j (m) with the relative velocity v_i − v_j (m/s); gradient = V ∇W_ij (1/m), times
  /// `share`.
  KOKKOS_INLINE_FUNCTION void add(Real share, const Real3& velocity, const Real3& r, const Real3& gradient) {
    pull += (share * dot(velocity, gradient)) * r;
    bound -= share * dot(r, gradient);
  }
};

/// −Ω_k² (x − c)_k along each axis, m/s²; `square` = Ω², 1/s².
KOKKOS_INLINE_FUNCTION Real3 central_field(const Real3& x, const Real3& center, const Real3& square) {
  return {-square.x * (x.x - center.x), -square.y * (x.y - center.y), -square.z * (x.z - center.z)};
}

}  // namespace drench::kokkos_backend
