#pragma once
// The pressure's iterations on a GPU in float, with half the bytes a pair (docs/dev/gpu_speed.md). From the third
// iteration on they work on what has changed since the second, which is evaluated in full: what a lean pair rounds is a
// part of that change.

#include "fluid/pressure_update.hpp"

namespace drench::kokkos_backend {

#if defined(KOKKOS_ENABLE_CUDA) && !defined(DRENCH_DOUBLE)
inline constexpr bool has_lean_pressure = true;
#else
inline constexpr bool has_lean_pressure = false;
#endif

/// Lists of one word a pair, and packed accelerations.
struct LeanPressure;

/// Makes the lists of a solve whose κ, work.predicted and work.liquid_rate are of one full evaluation.
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
