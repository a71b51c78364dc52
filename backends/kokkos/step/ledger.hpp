#pragma once
// One pass over the whole state, with one wait of the host: what stage ledger reports, and what the next step begins
// with.

#include "cloth/cloth.hpp"
#include "core/reduce.hpp"
#include "particles/fluid.hpp"
#include "state/host_state.hpp"

namespace drench::kokkos_backend {

/// What is summed over particles, or over nodes, edges and bodies; `saturation`, `speed`, `square` and `stretch` are
/// maxima.
struct LedgerSums {
  Quanta mass = 0;
  std::int64_t nonfinite = 0;
  ExactSum energy, mass_float;       // scaled by LedgerScale
  double saturation = 0, speed = 0;  // 1, m/s
  double square = 0, stretch = 0;    // |v|², m²/s²; of an edge's length over that at rest, squared, 1
  Tunnelled tunnelled;
  PointBounds bounds;  // of the liquid, m

  KOKKOS_INLINE_FUNCTION LedgerSums() { bounds.clear(); }
  KOKKOS_INLINE_FUNCTION LedgerSums& operator+=(const LedgerSums& o) {
    mass += o.mass;
    nonfinite += o.nonfinite;
    energy += o.energy;
    mass_float += o.mass_float;
    if (o.saturation > saturation) saturation = o.saturation;
    if (o.speed > speed) speed = o.speed;
    if (o.square > square) square = o.square;
    if (o.stretch > stretch) stretch = o.stretch;
    tunnelled += o.tunnelled;
    bounds.add(o.bounds);
    return *this;
  }
};

/// Of sums over so many particles or nodes, whose natural sizes are a full particle's mass and its energy at 1 m/s.
struct LedgerScale {
  ExactScale energy, mass;
  LedgerScale(const Constants& constants, double terms)
      : energy(terms, constants.model.particle_mass), mass(terms, constants.model.particle_mass) {}
};

/// Of the partial sums, of which the ledger's are the largest.
MemoryEstimate ledger_bytes(const Sizing& s);

/// What the pass has found beside its sums, of the liquid's positions.
struct StateMeasures {
  PointBounds fluid;                       // around the liquid
  double fluid_speed = 0, node_speed = 0;  // m/s: the fastest, as stage time_step asks (with `mode: cfl`)
};

/// Over the liquid of all ranks, and over nodes, edges and bodies; also fills `measured`.
SumPair<LedgerSums> measure(const Constants& constants, const Fluid& fluid, const Bodies& bodies, const Cloth& cloth,
                            Cached<StateMeasures>& measured);

}  // namespace drench::kokkos_backend
