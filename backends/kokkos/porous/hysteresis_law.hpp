#pragma once
// Retention with hysteresis: main curves of wetting and draining, and scanning curves between them (Kool & Parker
// 1987).
// Law: docs/theory/porous.md, section 18. All heights are over ℓ.

#include "core/types.hpp"

namespace drench::kokkos_backend::laws {

/// A change of the saturation that turns a node from wetting to draining, or back, 1.
inline constexpr double turning = 1e-3;

/// Where a node is on its curves: γ > 0 while it is wetted, −φ < 0 while it drains, 0 at first; the saturation farthest
/// on that way.
struct Scan {
  double curve, extreme;
};

struct Retention {
  double beta, ratio;  // β; ℓ_d/ℓ

  KOKKOS_INLINE_FUNCTION double power(double x, double exponent) const {
    return beta == 1 ? larger(0.0, x) : Kokkos::pow(larger(0.0, x), exponent);
  }
  /// 1 − h/ℓ at the saturation s.
  KOKKOS_INLINE_FUNCTION double held(double s, double curve) const {
    if (s >= 1) return power(s, beta);
    if (curve < 0) return s < -curve ? 1 - ratio * (1 - power(s / -curve, beta)) : 1;
    return power(1 - (1 - s) / (curve > 0 ? curve : 1), beta);
  }
  /// The saturation that fabric drained from full, or wetted from dry, has there.
  KOKKOS_INLINE_FUNCTION double drained(double at) const { return power(1 - (1 - at) / ratio, 1 / beta); }
  KOKKOS_INLINE_FUNCTION double wetted(double at) const { return power(at, 1 / beta); }

  /// At the saturation s now.
  KOKKOS_INLINE_FUNCTION Scan next(const Scan& last, double s) const {
    if (last.curve == 0 || s >= 1) return {1, s};
    if (last.curve > 0) {
      if (s >= last.extreme) return {last.curve, s};
      if (s > last.extreme - turning) return last;
      const double from = smaller(1.0, last.extreme);
      return {-smaller(1.0, from / drained(held(from, last.curve))), s};
    }
    if (s <= last.extreme) return {last.curve, s};
    if (s < last.extreme + turning) return last;
    const double dry = 1 - wetted(held(last.extreme, last.curve));
    return {dry > 0 ? smaller(1.0, (1 - last.extreme) / dry) : 1, s};
  }
};

/// BasicMaterial::has_hysteresis for kernels: nvcc does not call what is only constexpr.
template <class Material>
KOKKOS_INLINE_FUNCTION bool has_hysteresis(const Material& m) {
  return m.porous && m.diffusivity > 0 && m.drainage_height > m.capillary_height;
}
template <class Material>
KOKKOS_INLINE_FUNCTION Retention retention_of(const Material& m) {
  return {m.retention, has_hysteresis(m) ? double(m.drainage_height) / double(m.capillary_height) : 1};
}

}  // namespace drench::kokkos_backend::laws
