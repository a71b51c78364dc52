#pragma once
// The pressure's iterations on a GPU in float, with fewer gathered bytes (docs/dev/gpu_speed.md). From the third
// iteration on they work on what has changed since the second, which is evaluated in full: what a packed acceleration
// rounds is a part of that change.

#include "fluid/pressure_update.hpp"

namespace drench::kokkos_backend {

inline constexpr bool has_lean_pressure = compact_pairs;

/// Packed accelerations.
struct LeanPressure;

/// Begins with a solve whose κ, work.predicted and work.liquid_rate are of one full evaluation.
void begin_lean_pressure(PressureSystem& system);
/// a_i of what κ and λ have changed since then.
void predict_lean_liquid(PressureSystem& system);
/// The density rates of that, the update of each particle and its sums, and Nesterov's step with the weight `momentum`.
SumUnderWay<DensitySums> begin_lean_update(PressureSystem& system, const DensityUpdate& update, Real momentum,
                                           int slot);
SumUnderWay<IterationNorms> begin_lean_update(PressureSystem& system, const DivergenceUpdate& update, Real momentum,
                                              int slot);
/// work.predicted = the liquid's velocities of κ and λ.
void finish_lean_pressure(PressureSystem& system);

}  // namespace drench::kokkos_backend
