#pragma once
// The first evaluation of a pressure solve where nothing but liquid answers: its start is scaled to the size that fits
// (docs/theory/liquid.md, Eq. 20a).

#include "fluid/pressure_update.hpp"

namespace drench::kokkos_backend {

/// r_i of a start, 1, of the density rate, 1/s; what a solve judges it by.
struct StartResidual {
  Entries<const Real> ratio, alpha;
  Entries<const std::uint8_t> active;  // of the divergence solve
  Correction correction;               // of the density solve
  Real dt;                             // s
  Real factor;                         // ω/Δt², 1/s²
  bool density;                        // of the density solve; else of the divergence solve

  KOKKOS_INLINE_FUNCTION bool counts(Index i) const { return density ? alpha(i) > 0 : active(i) != 0; }
  KOKKOS_INLINE_FUNCTION Real operator()(Index i, Real rate) const {
    return density ? correction(ratio(i) - 1) + dt * rate : dt * rate;
  }
};

/// apply_pressure at s κ, which becomes κ. Returns the mean residual and complementarity at κ, 1. Waits for the device.
double apply_scaled_start(PressureSystem& system, const StartResidual& residual);

}  // namespace drench::kokkos_backend
