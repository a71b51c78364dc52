#pragma once
// What rules a collision out before it is computed in double, with room for its own rounding.

#include "core/types.hpp"

namespace drench::kokkos_backend {

/// A triangle that goes from `from` to `to` relative to a point that goes from x0 to x1, m: each difference of what is
/// stored, rounded once.
struct RelativeWay {
  Real3 a0, b0, c0, a1, b1, c1;  // corners, from the point
  Real3 e0, g0, e1, g1;          // b − a, c − a

  KOKKOS_INLINE_FUNCTION RelativeWay(const Real3& x0, const Real3& x1, const Real3* from, const Real3* to)
      : a0(from[0] - x0),
        b0(from[1] - x0),
        c0(from[2] - x0),
        a1(to[0] - x1),
        b1(to[1] - x1),
        c1(to[2] - x1),
        e0(from[1] - from[0]),
        g0(from[2] - from[0]),
        e1(to[1] - to[0]),
        g1(to[2] - to[0]) {}
};

KOKKOS_INLINE_FUNCTION Real least_of(Real a, Real b, Real c, Real d, Real e, Real f) {
  return smaller(smaller(smaller(a, b), smaller(c, d)), smaller(e, f));
}
KOKKOS_INLINE_FUNCTION Real most_of(Real a, Real b, Real c, Real d, Real e, Real f) {
  return larger(larger(larger(a, b), larger(c, d)), larger(e, f));
}
KOKKOS_INLINE_FUNCTION Real largest(const Real3& a, const Real3& b) {
  return larger(larger(larger(Kokkos::abs(a.x), Kokkos::abs(a.y)), larger(Kokkos::abs(a.z), Kokkos::abs(b.x))),
                larger(Kokkos::abs(b.y), Kokkos::abs(b.z)));
}

/// Does the box of the way leave the point out, by more than `margin` (m) and 1e-4 of itself? The triangle meets the
/// point only within the hull of the six corners; what counts as a hit beyond that is 1e-6 of an edge.
KOKKOS_INLINE_FUNCTION bool passes_by(const RelativeWay& w, Real margin) {
  const Real3 lo{least_of(w.a0.x, w.b0.x, w.c0.x, w.a1.x, w.b1.x, w.c1.x),
                 least_of(w.a0.y, w.b0.y, w.c0.y, w.a1.y, w.b1.y, w.c1.y),
                 least_of(w.a0.z, w.b0.z, w.c0.z, w.a1.z, w.b1.z, w.c1.z)};
  const Real3 hi{most_of(w.a0.x, w.b0.x, w.c0.x, w.a1.x, w.b1.x, w.c1.x),
                 most_of(w.a0.y, w.b0.y, w.c0.y, w.a1.y, w.b1.y, w.c1.y),
                 most_of(w.a0.z, w.b0.z, w.c0.z, w.a1.z, w.b1.z, w.c1.z)};
  const Real grow = margin + Real(1e-4) * largest(hi - lo, Real3{});
  return lo.x > grow || lo.y > grow || lo.z > grow || hi.x < -grow || hi.y < -grow || hi.z < -grow;
}

/// Does the point stay on one side of the triangle's plane, farther than `touch` (m) from it at the end? The
/// coplanarity's Bernstein coefficients on [0, 1] have one sign by more than their rounding: with |p| ≤ P, |e| ≤ E, |g|
/// ≤ G in the largest norm those of p·(e × g) are off by less than 27 ε P E G.
KOKKOS_INLINE_FUNCTION bool stays_on_its_side(const RelativeWay& w, Real touch) {
  const Real3 n0 = cross(w.e0, w.g0), n1 = cross(w.e1, w.g1), mixed = cross(w.e1, w.g0) + cross(w.e0, w.g1);
  const Real b0 = dot(w.a0, n0), b1 = (dot(w.a1, n0) + dot(w.a0, mixed)) / 3,
             b2 = (dot(w.a0, n1) + dot(w.a1, mixed)) / 3, b3 = dot(w.a1, n1);
  const Real rounding =
      32 * Kokkos::Experimental::epsilon_v<Real> * largest(w.a0, w.a1) * largest(w.e0, w.e1) * largest(w.g0, w.g1);
  const Real limit = rounding + touch * (Kokkos::abs(n1.x) + Kokkos::abs(n1.y) + Kokkos::abs(n1.z));
  const Real least = smaller(smaller(b0, b1), smaller(b2, b3));
  const Real most = larger(larger(b0, b1), larger(b2, b3));
  return least > limit || most < -limit;
}

}  // namespace drench::kokkos_backend
