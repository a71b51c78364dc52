#pragma once
// The cubic spline kernel; law and source in src/stages/kernel.hpp.

#include "types.hpp"

namespace drench::kokkos_backend {

struct CubicKernel {
  Real h, inverse_h, sigma;  // m, 1/m, 1/m³

  explicit CubicKernel(Real support)
      : h(support),
        inverse_h(1 / support),
        sigma(Real(8 / (3.14159265358979323846 * double(support) * support * support))) {}

  /// W(r), 1/m³.
  KOKKOS_INLINE_FUNCTION Real value(Real r) const {
    const Real q = r * inverse_h;
    if (q >= 1) return 0;
    const Real p = 1 - q;
    return q <= Real(0.5) ? sigma * (6 * q * q * (q - 1) + 1) : sigma * 2 * p * p * p;
  }
  /// (dW/dr)/r, 1/m⁵, so that ∇W_ij = slope(r) (x_i − x_j). Finite at r = 0.
  KOKKOS_INLINE_FUNCTION Real slope(Real r) const {
    const Real q = r * inverse_h;
    if (q >= 1) return 0;
    const Real p = 1 - q;
    const Real scale = sigma * inverse_h * inverse_h;
    return q <= Real(0.5) ? scale * 6 * (3 * q - 2) : -scale * 6 * p * p / q;
  }
};

}  // namespace drench::kokkos_backend
