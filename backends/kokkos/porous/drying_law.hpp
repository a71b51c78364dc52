#pragma once
// How wet cloth dries: the law of docs/theory/evaporation.md, section 2.

#include "porous/permeation_law.hpp"

namespace drench::kokkos_backend::laws {

/// How much of a side with Σ V W of liquid and solids the air reaches, 1.
KOKKOS_INLINE_FUNCTION double open_part(double filled) { return filled < covered_side ? 1 - filled / covered_side : 0; }

/// w ≤ 0 with w + b (e^w − 1) + due = 0. The left side is convex and rises, so Newton's method comes from above.
KOKKOS_INLINE_FUNCTION double logarithm_left(double b, double due) {
  if (b == 0) return -due;
  double w = 0;
  for (int k = 0; k < 10; ++k) {
    const double fallen = b * Kokkos::expm1(w);
    w -= (w + fallen + due) / (1 + b + fallen);
  }
  return w;
}

/// What goes from a mass in dt if `rate` goes above the critical mass, and below it the wet part x of the surface loses
/// rate (1 + β) x/(1 + β x), with β = `cooling`; never more than there is.
KOKKOS_INLINE_FUNCTION double dried(double mass, double critical, double rate, double cooling, double dt) {
  const double above = mass > critical ? mass - critical : 0, due = rate * dt;
  if (!(critical > 0) || due <= above) return due < mass ? due : mass;
  const double start = mass < critical ? mass : critical;
  return above -
         start * Kokkos::expm1(logarithm_left(cooling * start / critical, (1 + cooling) * (due - above) / critical));
}

}  // namespace drench::kokkos_backend::laws
