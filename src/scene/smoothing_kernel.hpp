#pragma once
// The smoothing kernels' values for set-up; laws in src/stages/kernel.hpp.

#include "scene/scene.hpp"

namespace drench {

/// W(r) in three dimensions, zero at r ≥ h; 1/m³.
double kernel_value(KernelKind kernel, double r, double h);

/// Density ratio of a full cubic lattice of spacing d with h = support · d, 1.
double lattice_density(KernelKind kernel, double support);

}  // namespace drench
