#pragma once
// The pressure's iterations on a GPU in float, with fewer bytes a pair (docs/design-notes/gpu_speed.md): an approximate operator
// that the solve iterates with; what it ends with is evaluated in full.

#include <memory>

#include "fluid/pressure_solve.hpp"

namespace drench::kokkos_backend {

/// Lists of one word a pair and packed accelerations; empty where there are none.
struct LeanPressure;

/// Makes them for a solve that begins at the velocities as they are, or returns false: not on CUDA, or in double.
bool begin_lean_pressure(PressureSystem& system);
/// a_i(κ, λ) and, beside sheets, work.predicted, as predict_liquid has them.
void predict_lean_liquid(PressureSystem& system);
/// work.density_rate and work.approach_rate, as measure_density_rate has them.
void measure_lean_density_rate(PressureSystem& system);

}  // namespace drench::kokkos_backend
