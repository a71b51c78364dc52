#pragma once
// The first evaluation of a pressure solve where nothing but liquid answers: its start is scaled to the size that fits
// (docs/theory/liquid.md, Eq. 20a).

#include "fluid/pressure_update.hpp"

namespace drench::kokkos_backend {

/// r_i of a start, 1, of the density rate, 1/s.
struct StartResidual {
  Entries<const Real> ratio;
  Real correction, dt;  // c, 1; s
  bool density;         // of the density solve; else of the divergence solve

  KOKKOS_INLINE_FUNCTION Real operator()(Index i, Real rate) const {
    return density ? corrected(ratio(i) - 1, correction) + dt * rate : dt * rate;
  }
};

/// apply_pressure at s κ, which becomes κ. Waits for the device.
void apply_scaled_start(PressureSystem& system, const StartResidual& residual);

}  // namespace drench::kokkos_backend
