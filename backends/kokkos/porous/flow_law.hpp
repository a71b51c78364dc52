#pragma once
// Where the liquid in the cloth wants to go: paper Eqs. 4–6 with the signs of src/stages/flow_direction.hpp.

#include "core/types.hpp"

namespace drench::kokkos_backend::laws {

/// ε of Eq. 6, m/s²: a thousandth of gravity, or of the virtual pressure's k^p where there is no gravity.
KOKKOS_INLINE_FUNCTION Real flow_regularisation(Real gravity, Real virtual_pressure) {
  return Real(1e-3) * (gravity > 0 ? gravity : virtual_pressure);
}

/// P^h of flow_direction.hpp, m/s²: the virtual pressure as far as it holds gravity off the solid. Where the solid is
/// so level that less than g/4 pulls along it, also what lifts the flow off it. Without gravity all of P′.
KOKKOS_INLINE_FUNCTION Real3 holding_pressure(const Real3& pressure, const Real3& gravity) {
  const Real size = norm(pressure), g = norm(gravity);
  if (!(size > 0) || !(g > 0)) return pressure;
  const Real3 away = (1 / size) * pressure;
  const Real into = -dot(gravity, away);
  const Real spare = g / 4 - norm(gravity + into * away);
  const Real limit = (into > 0 ? into : Real(0)) + (spare > 0 ? spare : Real(0));
  return size > limit ? limit * away : pressure;
}

/// v_p = X/(|X| + ε), 1; X = P^h + g, of the emission P′ + g, m/s² (Eqs. 5, 6). 0 if X = 0.
KOKKOS_INLINE_FUNCTION Real3 flow_direction(const Real3& x, Real epsilon) {
  const Real length = norm(x);
  return length > 0 ? (1 / (length + epsilon)) * x : Real3{};
}

/// Cosine of the angle between a separation and a flow direction, 1; 0 where either has no direction (r ≤ 1e-9 h).
KOKKOS_INLINE_FUNCTION Real flow_cosine(const Real3& separation, const Real3& flow, Real support) {
  const Real r = norm(separation), f = norm(flow);
  return r > Real(1e-9) * support && f > 0 ? dot(separation, flow) / (r * f) : Real(0);
}

/// Is a separation (m) inside the emission cone about the flow direction? Paper section 3.4, cos θ > cos θ^e. Without a
/// cone (`emission_cosine` below −1) it is.
KOKKOS_INLINE_FUNCTION bool in_cone(const Real3& separation, const Real3& flow, Real emission_cosine, Real support) {
  const Real r = norm(separation), f = norm(flow);
  if (!(r > Real(1e-9) * support)) return false;
  return emission_cosine < -1 || (f > 0 && dot(separation, flow) > emission_cosine * (r * f));
}

/// Do two samples of the same cloth, this far apart at rest (m), belong to different layers of it (a fold)?
KOKKOS_INLINE_FUNCTION bool folded_apart(const Real3& rest_separation, Real support) {
  return dot(rest_separation, rest_separation) >= 4 * support * support;
}

}  // namespace drench::kokkos_backend::laws
