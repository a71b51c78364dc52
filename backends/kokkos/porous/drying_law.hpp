#pragma once
// How wet cloth dries: the law of docs/theory/evaporation.md, section 2.

#include "porous/permeation_law.hpp"

namespace drench::kokkos_backend::laws {

/// How much of a side with Σ V W of liquid and solids the air reaches, 1.
KOKKOS_INLINE_FUNCTION double open_part(double filled) { return filled < covered_side ? 1 - filled / covered_side : 0; }

/// What goes from a mass in dt if `rate` goes above the critical mass, and in proportion below it; never more than
/// there is.
KOKKOS_INLINE_FUNCTION double dried(double mass, double critical, double rate, double dt) {
  const double above = mass > critical ? mass - critical : 0, due = rate * dt;
  if (!(critical > 0) || due <= above) return due < mass ? due : mass;
  const double start = mass < critical ? mass : critical;
  return above - start * Kokkos::expm1(-(due - above) / critical);
}

}  // namespace drench::kokkos_backend::laws
