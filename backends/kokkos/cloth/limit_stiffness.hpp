#pragma once
// What a triangle's strain limit resists with at an iterate, for the matrices of Newton's method (docs/theory/cloth.md,
// section 8).

#include "cloth/membrane_stiffness.hpp"

namespace drench::kokkos_backend {

/// What a triangle's strain limit resists with between corner gradients: of each stretch beyond the limit.
struct LimitStiffness {
  Block along[2];
  CornerGradient axis[2];

  KOKKOS_INLINE_FUNCTION Block between(const CornerGradient& a, const CornerGradient& b) const {
    Block k;
    for (int i = 0; i < 2; ++i)
      k.add(along[i], (a.x * axis[i].x + a.y * axis[i].y) * (b.x * axis[i].x + b.y * axis[i].y));
    return k;
  }
};

/// Of triangle t; false: it is within its limit.
template <class Shift>
KOKKOS_INLINE_FUNCTION bool limit_stiffness(const ClothSystem& s, Index t, const Shift& shift, LimitStiffness& out) {
  const Index a = s.triangle(3 * t), b = s.triangle(3 * t + 1), c = s.triangle(3 * t + 2);
  const TriangleShape shape = s.triangle_shape(t);
  const Real3 e1 = separation(s.start(b), shift(b), s.start(a), shift(a)),
              e2 = separation(s.start(c), shift(c), s.start(a), shift(a));
  const Real3 f1 = shape.xx * e1, f2 = shape.xy * e1 + shape.yy * e2;
  const Real p = dot(f1, f1), q = dot(f1, f2), r = dot(f2, f2);
  const Real middle = Real(0.5) * (p + r), apart = Real(0.5) * (p - r), radius = Kokkos::sqrt(apart * apart + q * q);
  const Real cosine = radius > 0 ? apart / radius : Real(1);  // of twice the first axis' angle
  const Real x = Kokkos::sqrt(larger(Real(0), Real(0.5) * (1 + cosine))),
             y = Kokkos::sqrt(larger(Real(0), Real(0.5) * (1 - cosine))) * (q < 0 ? Real(-1) : Real(1));
  out.axis[0] = {x, y};
  out.axis[1] = {-y, x};
  const Real square[2] = {middle + radius, larger(Real(0), middle - radius)};
  bool any = false;
  for (int i = 0; i < 2; ++i) {
    out.along[i] = {};
    const Real beyond = beyond_limit(square[i], s.materials(a).strain_limit);
    if (beyond == 0) continue;
    any = true;
    const Real taut = larger(Real(0), beyond), stiff = s.limit_stiffness(t);
    out.along[i].add(stiff * taut);
    out.along[i].add(stiff * (1 - taut) / square[i], out.axis[i].x * f1 + out.axis[i].y * f2);
  }
  return any;
}

}  // namespace drench::kokkos_backend
