#pragma once
// The wet part of a triangle whose saturation is linear (docs/theory/porous.md, section 15).

#include <Kokkos_Core.hpp>

namespace drench::kokkos_backend::laws {

/// The part of a triangle in which a linear function is not negative, 1, from its values at the corners.
KOKKOS_INLINE_FUNCTION double part_above(double a, double b, double c) {
  const double low = smaller(a, smaller(b, c)), high = larger(a, larger(b, c));
  const double middle = larger(smaller(a, b), smaller(larger(a, b), c));
  if (low >= 0) return 1;
  if (high < 0) return 0;
  if (middle < 0) return high * high / ((high - middle) * (high - low));
  return 1 - low * low / ((middle - low) * (high - low));
}

}  // namespace drench::kokkos_backend::laws
