#pragma once
// Nearest points of a point and a triangle, and of two segments (Ericson 2005), and conservative advancement, in double
// (src/stages/self_collision.hpp, law 2).

#include "core/double3.hpp"

namespace drench::kokkos_backend {

/// Nearest points of two primitives of four points: Σ b_k x_k leads from the second's to the first's.
struct Proximity {
  double distance = 0;  // m
  double b[4] = {0, 0, 0, 0};
  Double3 apart;  // m: from the second's nearest point to the first's
};

KOKKOS_INLINE_FUNCTION double clamp01(double t) { return t < 0 ? 0 : t > 1 ? 1 : t; }

/// Point x[0] and triangle x[1..3].
KOKKOS_INLINE_FUNCTION void nearest_on_triangle(const Double3* x, double* w) {
  const Double3 ab = minus(x[2], x[1]), ac = minus(x[3], x[1]);
  const Double3 ap = minus(x[0], x[1]), bp = minus(x[0], x[2]), cp = minus(x[0], x[3]);
  const double d1 = inner(ab, ap), d2 = inner(ac, ap), d3 = inner(ab, bp), d4 = inner(ac, bp), d5 = inner(ab, cp),
               d6 = inner(ac, cp);
  w[0] = w[1] = w[2] = 0;
  if (d1 <= 0 && d2 <= 0) {
    w[0] = 1;
    return;
  }
  if (d3 >= 0 && d4 <= d3) {
    w[1] = 1;
    return;
  }
  const double vc = d1 * d4 - d3 * d2;
  if (vc <= 0 && d1 >= 0 && d3 <= 0) {
    w[1] = d1 / (d1 - d3);
    w[0] = 1 - w[1];
    return;
  }
  if (d6 >= 0 && d5 <= d6) {
    w[2] = 1;
    return;
  }
  const double vb = d5 * d2 - d1 * d6;
  if (vb <= 0 && d2 >= 0 && d6 <= 0) {
    w[2] = d2 / (d2 - d6);
    w[0] = 1 - w[2];
    return;
  }
  const double va = d3 * d6 - d5 * d4;
  if (va <= 0 && d4 - d3 >= 0 && d5 - d6 >= 0) {
    w[2] = (d4 - d3) / ((d4 - d3) + (d5 - d6));
    w[1] = 1 - w[2];
    return;
  }
  w[1] = vb / (va + vb + vc);
  w[2] = vc / (va + vb + vc);
  w[0] = 1 - w[1] - w[2];
}

/// Segments x[0] x[1] and x[2] x[3]: the nearest points lie at s and t along them. Edges of cloth have a length.
KOKKOS_INLINE_FUNCTION void nearest_on_segments(const Double3* x, double& s, double& t) {
  const Double3 d1 = minus(x[1], x[0]), d2 = minus(x[3], x[2]), r = minus(x[0], x[2]);
  const double a = inner(d1, d1), e = inner(d2, d2), f = inner(d2, r), c = inner(d1, r), b = inner(d1, d2);
  const double determinant = a * e - b * b;
  s = determinant > 1e-14 * a * e ? clamp01((b * f - c * e) / determinant) : 0;
  t = e > 0 ? (b * s + f) / e : 0;
  if (t < 0 || t > 1) {
    t = clamp01(t);
    s = a > 0 ? clamp01((b * t - c) / a) : 0;
  }
}

KOKKOS_INLINE_FUNCTION Proximity proximity(bool edges, const Double3* x) {
  Proximity p;
  if (edges) {
    double s, t;
    nearest_on_segments(x, s, t);
    p.b[0] = 1 - s;
    p.b[1] = s;
    p.b[2] = t - 1;
    p.b[3] = -t;
  } else {
    double w[3];
    nearest_on_triangle(x, w);
    p.b[0] = 1;
    for (int k = 0; k < 3; ++k) p.b[k + 1] = -w[k];
  }
  // Relative to one of the points, so that nothing cancels.
  for (int k = 1; k < 4; ++k) p.apart = add(p.apart, times(p.b[k], minus(x[k], x[0])));
  p.distance = Kokkos::sqrt(inner(p.apart, p.apart));
  return p;
}

/// l: the most by which the pair's distance changes in the step, m. `u` becomes relative to its mean.
KOKKOS_INLINE_FUNCTION double relative_travel(bool edges, Double3* u) {
  const Double3 mean = times(0.25, add(add(u[0], u[1]), add(u[2], u[3])));
  double largest[2] = {0, 0};
  for (int k = 0; k < 4; ++k) {
    u[k] = minus(u[k], mean);
    double& l = largest[k < (edges ? 2 : 1) ? 0 : 1];
    l = larger(l, Kokkos::sqrt(inner(u[k], u[k])));
  }
  return largest[0] + largest[1];
}

/// Law 2: does the pair come as near as `gap` within the step? Then `near` is how it stands at that time.
KOKKOS_INLINE_FUNCTION bool reaches(bool edges, const Double3* start, const Double3* displacement, double gap,
                                    Proximity& near) {
  constexpr int most_advances = 200;
  Double3 u[4], x[4];
  for (int k = 0; k < 4; ++k) u[k] = displacement[k];
  const double l = relative_travel(edges, u);
  double t = 0;
  for (int advance = 0;; ++advance) {
    for (int k = 0; k < 4; ++k) x[k] = add(start[k], times(t, u[k]));
    near = proximity(edges, x);
    const double left = near.distance - gap;
    if (left <= 0.01 * gap || advance == most_advances) return true;
    if (left >= (1 - t) * l) return false;
    t += left / l;
  }
}

}  // namespace drench::kokkos_backend
