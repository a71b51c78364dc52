#pragma once
// The point of a triangle that is nearest to another point (Ericson 2005, section 5.1.5).

#include "core/types.hpp"

namespace drench::kokkos_backend {

struct NearestPoint {
  Real weight[3];  // barycentric
  int part;        // what it lies on: 0, 1, 2 the corner; 3, 4, 5 the edge opposite to corner part − 3; 6 the inside
};

/// Of the triangle a, b, c to x, m. A triangle without area gives a point of one of its edges.
KOKKOS_INLINE_FUNCTION NearestPoint nearest_point(const Real3& a, const Real3& b, const Real3& c, const Real3& x) {
  const Real3 ab = b - a, ac = c - a, ax = x - a, bx = x - b, cx = x - c;
  const Real d1 = dot(ab, ax), d2 = dot(ac, ax);
  if (d1 <= 0 && d2 <= 0) return {{1, 0, 0}, 0};
  const Real d3 = dot(ab, bx), d4 = dot(ac, bx);
  if (d3 >= 0 && d4 <= d3) return {{0, 1, 0}, 1};
  const Real vc = d1 * d4 - d3 * d2;
  if (vc <= 0 && d1 >= 0 && d3 <= 0 && d1 > d3) return {{1 - d1 / (d1 - d3), d1 / (d1 - d3), 0}, 5};
  const Real d5 = dot(ab, cx), d6 = dot(ac, cx);
  if (d6 >= 0 && d5 <= d6) return {{0, 0, 1}, 2};
  const Real vb = d5 * d2 - d1 * d6;
  if (vb <= 0 && d2 >= 0 && d6 <= 0 && d2 > d6) return {{1 - d2 / (d2 - d6), 0, d2 / (d2 - d6)}, 4};
  const Real va = d3 * d6 - d5 * d4, s = d4 - d3, u = d5 - d6;
  if (va <= 0 && s >= 0 && u >= 0 && s + u > 0) return {{0, 1 - s / (s + u), s / (s + u)}, 3};
  const Real sum = va + vb + vc;
  if (!(sum > 0)) return {{1, 0, 0}, 0};
  return {{1 - vb / sum - vc / sum, vb / sum, vc / sum}, 6};
}

}  // namespace drench::kokkos_backend
