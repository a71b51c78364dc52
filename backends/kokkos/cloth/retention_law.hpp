#pragma once
// Retention: curves of one or of two kinds of pores; with hysteresis main curves of wetting and draining, and scanning
// curves between them (Kool & Parker 1987).
// Law: docs/theory/porous.md, sections 18 and 19. All heights are over ℓ; y = 1 − h/ℓ of the suction h.

#include "core/types.hpp"

namespace drench::kokkos_backend::laws {

/// A change of the saturation that turns a node from wetting to draining, or back, 1.
inline constexpr double turning = 1e-3;

/// ν, 1: by what pores of fabric with the narrowing c are finer at the area strain e (docs/theory/porous.md, Eq. 53).
KOKKOS_INLINE_FUNCTION double narrowing_at(double c, double e) { return larger(0.25, smaller(4.0, 1 + c * e)); }

/// Where a node is on its curves: γ > 0 while it is wetted, −φ < 0 while it drains, 0 at first; the saturation
/// farthest on that way.
struct Scan {
  double curve, extreme;
};

/// How full small and large pores are, 1.
struct PoreFilling {
  double small, large;
};

/// What a node draws with.
struct NodeSuction {
  double held;          // 1 − h/ℓ
  PoreFilling filling;  // with pores of two sizes
};

/// A main curve, S = (1 − w) y^(1/β) + w (1 − (1 − y) ℓ/ℓ₂)^(1/β).
struct PoreCurve {
  double beta = 1, large = 0, narrowing = 1;  // β; w, ℓ/ℓ₂

  KOKKOS_INLINE_FUNCTION double power(double x, double exponent) const {
    return beta == 1 ? larger(0.0, x) : Kokkos::pow(larger(0.0, x), exponent);
  }
  KOKKOS_INLINE_FUNCTION PoreFilling filling(double y) const {
    return {power(y, 1 / beta), power(1 - (1 - y) * narrowing, 1 / beta)};
  }
  KOKKOS_INLINE_FUNCTION double saturation(double y) const {
    if (!(large > 0)) return power(y, 1 / beta);
    const PoreFilling f = filling(y);
    return (1 - large) * f.small + large * f.large;
  }
  /// y at a saturation of 1 at most.
  KOKKOS_INLINE_FUNCTION double held(double s) const {
    if (!(large > 0)) return power(s, beta);
    const double first = 1 - 1 / narrowing, emptied = (1 - large) * power(first, 1 / beta);
    if (s <= emptied) return power(s / (1 - large), beta);
    if (beta == 1) return 1 - (1 - s) / (1 - large + large * narrowing);
    // Newton's method for the filling q of the large pores, to 1e-14: S(q) has no steep parts.
    double q = smaller(1.0, (s - emptied) / (1 - emptied));
    for (int k = 0; k < 6; ++k) {
      const double rise = Kokkos::pow(q, beta) / narrowing, y = first + rise, small = Kokkos::pow(y, 1 / beta);
      const double slope = large + (q > 0 ? (1 - large) * small / y * rise / q : 0);
      q = smaller(1.0, larger(0.0, q - ((1 - large) * small + large * q - s) / slope));
    }
    return first + Kokkos::pow(q, beta) / narrowing;
  }
};

struct Retention {
  PoreCurve wetting, draining;
  double ratio = 1;  // ℓ_d/ℓ; 1: without hysteresis, `wetting` is all

  /// 1 − h/ℓ at the saturation s.
  KOKKOS_INLINE_FUNCTION double held(double s, double curve) const {
    if (s >= 1) return wetting.power(s, wetting.beta);
    if (curve < 0) return s < -curve ? 1 - ratio * (1 - draining.held(s / -curve)) : 1;
    return wetting.held(larger(0.0, 1 - (1 - s) / (curve > 0 ? curve : 1)));
  }
  /// The saturation that fabric drained from full, or wetted from dry, has there.
  KOKKOS_INLINE_FUNCTION double drained(double at) const { return draining.saturation(1 - (1 - at) / ratio); }
  KOKKOS_INLINE_FUNCTION double wetted(double at) const { return wetting.saturation(at); }
  /// On the main curve of wetting.
  KOKKOS_INLINE_FUNCTION PoreFilling filling(double s) const {
    return s >= 1 ? PoreFilling{s, s} : wetting.filling(wetting.held(s));
  }

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

}  // namespace drench::kokkos_backend::laws
