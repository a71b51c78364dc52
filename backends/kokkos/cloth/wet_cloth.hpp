#pragma once
// What wetness does to the fabric's own numbers.

#include "core/types.hpp"

namespace drench::kokkos_backend {

/// s_n = min(1, m_f/C_n), 1: liquid in quanta of `quantum` kg, capacity in kg; dry where it holds none.
KOKKOS_INLINE_FUNCTION Real node_saturation(Quanta liquid, double quantum, double capacity) {
  return capacity > 0 ? Real(Kokkos::fmin(1.0, quantum * static_cast<double>(liquid) / capacity)) : Real(0);
}

/// Friction (1) or damping (1/s) at saturation s, linear between its dry value and that at s = 1.
KOKKOS_INLINE_FUNCTION Real at_saturation(Real dry, Real wet, Real saturation) {
  return dry + saturation * (wet - dry);
}

}  // namespace drench::kokkos_backend
