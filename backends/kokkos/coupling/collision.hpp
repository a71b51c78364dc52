#pragma once
// Continuous collision of a moving point with a linearly moving triangle (Provot 1997; Bridson et al. 2002), in double.

#include "core/double3.hpp"

namespace drench::kokkos_backend {

/// A triangle at one time, m.
struct Corners {
  Double3 a, b, c;
  KOKKOS_INLINE_FUNCTION Double3 at(const double* w) const {
    return add(times(w[0], a), add(times(w[1], b), times(w[2], c)));
  }
  /// The unit normal, or 0 for a triangle without area.
  KOKKOS_INLINE_FUNCTION Double3 normal() const {
    const Double3 n = outer(minus(b, a), minus(c, a));
    const double length = Kokkos::sqrt(inner(n, n));
    return length > 0 ? times(1 / length, n) : Double3{};
  }
};
KOKKOS_INLINE_FUNCTION Corners blend(const Corners& from, const Corners& to, double t) {
  return {add(times(1 - t, from.a), times(t, to.a)), add(times(1 - t, from.b), times(t, to.b)),
          add(times(1 - t, from.c), times(t, to.c))};
}

/// Barycentric coordinates of the foot point of x in the triangle's plane; false for a triangle without area. By cross
/// products: Gram's matrix would lose the digits of slivers.
KOKKOS_INLINE_FUNCTION bool barycentric(const Corners& t, const Double3& x, double* w) {
  const Double3 e = minus(t.b, t.a), g = minus(t.c, t.a), p = minus(x, t.a), n = outer(e, g);
  const double square = inner(n, n);
  if (!(square > 1e-14 * inner(e, e) * inner(g, g))) return false;
  w[1] = inner(outer(p, g), n) / square;
  w[2] = inner(outer(e, p), n) / square;
  w[0] = 1 - w[1] - w[2];
  return true;
}

/// Square of the distance of x to the segment a b, m².
KOKKOS_INLINE_FUNCTION double segment_square(const Double3& x, const Double3& a, const Double3& b) {
  const Double3 e = minus(b, a), p = minus(x, a);
  const double length = inner(e, e), s = length > 0 ? smaller(1.0, larger(0.0, inner(p, e) / length)) : 0;
  const Double3 away = minus(p, times(s, e));
  return inner(away, away);
}

/// Is x no farther from one of the edges than 1e-6 of the longest?
KOKKOS_INLINE_FUNCTION bool on_an_edge(const Corners& t, const Double3& x) {
  const Double3 u = minus(t.b, t.a), v = minus(t.c, t.b), w = minus(t.a, t.c);
  const double longest = larger(larger(inner(u, u), inner(v, v)), inner(w, w));
  const double nearest =
      smaller(smaller(segment_square(x, t.a, t.b), segment_square(x, t.b, t.c)), segment_square(x, t.c, t.a));
  return nearest <= 1e-12 * longest;
}

KOKKOS_INLINE_FUNCTION double cubic_value(const double* c, double t) {
  return ((c[3] * t + c[2]) * t + c[1]) * t + c[0];
}

/// Do the cubic's Bernstein coefficients on [0, 1] all have one sign, beyond rounding? Then it has no root there.
KOKKOS_INLINE_FUNCTION bool keeps_its_sign(const double* c) {
  const double b[4] = {c[0], c[0] + c[1] / 3, c[0] + (2 * c[1] + c[2]) / 3, c[0] + c[1] + c[2] + c[3]};
  const double least = smaller(smaller(b[0], b[1]), smaller(b[2], b[3]));
  const double most = larger(larger(b[0], b[1]), larger(b[2], b[3]));
  const double rounding = 1e-13 * (Kokkos::abs(c[0]) + Kokkos::abs(c[1]) + Kokkos::abs(c[2]) + Kokkos::abs(c[3]));
  return least > rounding || most < -rounding;
}

/// Where the cubic, monotone on [lo, hi], changes the sign that it has at lo: Newton's steps within a bracket that
/// every value narrows; a halving where a step leaves the bracket or is more than half of the last one. Ends when the
/// value is no more than its rounding, the step is below the last digit, or nothing lies within the bracket any more.
KOKKOS_INLINE_FUNCTION double bracketed_root(const double* c, double lo, double hi, double at_lo, double at_hi) {
  constexpr double digit = 2.2e-16;
  const bool below = at_lo < 0;
  double last = hi - lo, x = lo + last * (at_lo / (at_lo - at_hi));
  if (!(x > lo && x < hi)) x = 0.5 * (lo + hi);
  for (int count = 0; count < 80; ++count) {
    const double value = cubic_value(c, x), slope = (3 * c[3] * x + 2 * c[2]) * x + c[1];
    const double terms = ((Kokkos::abs(c[3]) * x + Kokkos::abs(c[2])) * x + Kokkos::abs(c[1])) * x + Kokkos::abs(c[0]);
    if (Kokkos::abs(value) <= digit * terms) return x;
    if ((value < 0) == below)
      lo = x;
    else
      hi = x;
    const double step = value / slope;
    if (Kokkos::abs(step) <= digit * x) return x;
    double next = x - step;
    if (!(next > lo && next < hi) || Kokkos::abs(step) > 0.5 * last) next = 0.5 * (lo + hi);
    if (!(next > lo && next < hi)) return x;
    last = Kokkos::abs(next - x);
    x = next;
  }
  return x;
}

/// All roots in [0, 1] of c0 + c1 t + c2 t² + c3 t³ where it changes sign or is exactly 0, ascending; at most 4. The
/// extrema split [0, 1] into monotone pieces, each bracketed, so that vanishing leading coefficients need no case.
KOKKOS_INLINE_FUNCTION int cubic_roots(const double* c, double* roots) {
  double knots[4] = {0, 1, 1, 1};
  int pieces = 1;
  double extremum[2] = {-1, -1};
  const double a = 3 * c[3], b = 2 * c[2], discriminant = b * b - 4 * a * c[1];
  if (discriminant >= 0) {
    const double q = -0.5 * (b + Kokkos::copysign(Kokkos::sqrt(discriminant), b));
    if (a != 0) extremum[0] = q / a;
    if (q != 0) extremum[1] = c[1] / q;
  }
  if (extremum[0] > extremum[1]) {
    const double swap = extremum[0];
    extremum[0] = extremum[1];
    extremum[1] = swap;
  }
  for (int k = 0; k < 2; ++k)
    if (extremum[k] > 0 && extremum[k] < 1) knots[pieces++] = extremum[k];
  knots[pieces] = 1;
  int found = 0;
  for (int k = 0; k < pieces; ++k) {
    const double lo = knots[k], hi = knots[k + 1];
    const double at_lo = cubic_value(c, lo), at_hi = cubic_value(c, hi);
    if (at_lo == 0) roots[found++] = lo;
    if (at_lo == 0 || at_hi == 0 || (at_lo < 0) == (at_hi < 0)) continue;
    roots[found++] = bracketed_root(c, lo, hi, at_lo, at_hi);
  }
  if (cubic_value(c, 1) == 0) roots[found++] = 1;
  return found;
}

/// A box, m.
struct Box {
  Real3 lo, hi;
  KOKKOS_INLINE_FUNCTION bool apart(const Box& o) const {
    return lo.x > o.hi.x || lo.y > o.hi.y || lo.z > o.hi.z || hi.x < o.lo.x || hi.y < o.lo.y || hi.z < o.lo.z;
  }
};

/// The box of a triangle's way from → to, grown by `margin` (m) and 1e-4 of itself. A path whose box is apart from it
/// cannot hit: what hits is within 1e-6 of an edge's length of the triangle.
KOKKOS_INLINE_FUNCTION Box box_of_way(const Corners& from, const Corners& to, double margin) {
  const auto least = [](double a, double b, double c, double d, double e, double f) {
    return smaller(smaller(smaller(a, b), smaller(c, d)), smaller(e, f));
  };
  Double3 lo{least(from.a.x, from.b.x, from.c.x, to.a.x, to.b.x, to.c.x),
             least(from.a.y, from.b.y, from.c.y, to.a.y, to.b.y, to.c.y),
             least(from.a.z, from.b.z, from.c.z, to.a.z, to.b.z, to.c.z)};
  Double3 hi{-least(-from.a.x, -from.b.x, -from.c.x, -to.a.x, -to.b.x, -to.c.x),
             -least(-from.a.y, -from.b.y, -from.c.y, -to.a.y, -to.b.y, -to.c.y),
             -least(-from.a.z, -from.b.z, -from.c.z, -to.a.z, -to.b.z, -to.c.z)};
  const Double3 size = minus(hi, lo), grown = add(times(1e-4, size), {margin, margin, margin});
  return {narrow(minus(lo, grown)), narrow(add(hi, grown))};
}

/// A hit of the path on a triangle: time τ ∈ [0, 1] of the step, barycentric coordinates. triangle < 0: none.
struct Hit {
  double time = 2;
  double weight[3] = {0, 0, 0};
  Index triangle = -1;

  /// Of two at the same time that with the first triangle.
  KOKKOS_INLINE_FUNCTION bool before(const Hit& o) const {
    return time < o.time || (time == o.time && triangle < o.triangle);
  }
};

/// The first τ at which x0 → x1 meets the triangle from → to: coplanarity (x − a)·((b − a) × (c − a)) = 0, m³, a cubic
/// in τ. τ = 1 always counts as a candidate, with the tolerance `touch` (m) on the distance to the plane.
KOKKOS_INLINE_FUNCTION bool first_hit(const Double3& x0, const Double3& x1, const Corners& from, const Corners& to,
                                      double touch, Hit& hit) {
  constexpr double margin = -1e-6;
  const Double3 p = minus(x0, from.a), e = minus(from.b, from.a), g = minus(from.c, from.a);
  const Double3 dp = minus(minus(x1, to.a), p), de = minus(minus(to.b, to.a), e), dg = minus(minus(to.c, to.a), g);
  const Double3 n0 = outer(e, g), n1 = add(outer(de, g), outer(e, dg)), n2 = outer(de, dg);
  const double c[4] = {inner(p, n0), inner(p, n1) + inner(dp, n0), inner(p, n2) + inner(dp, n1), inner(dp, n2)};
  double roots[5];
  int count = keeps_its_sign(c) ? 0 : cubic_roots(c, roots);
  const Double3 end_normal = to.normal();
  if (Kokkos::abs(inner(minus(x1, to.a), end_normal)) <= touch) roots[count++] = 1;
  for (int k = 0; k < count; ++k) {
    const double t = roots[k];
    double w[3];
    const Corners at = blend(from, to, t);
    const Double3 x = add(times(1 - t, x0), times(t, x1));
    if (!barycentric(at, x, w)) continue;
    if ((w[0] < margin || w[1] < margin || w[2] < margin) && !on_an_edge(at, x)) continue;
    hit.time = t;
    for (int a = 0; a < 3; ++a) hit.weight[a] = w[a];
    return true;
  }
  return false;
}

}  // namespace drench::kokkos_backend
