#pragma once
// The smoothing kernels' values for set-up; laws in src/stages/kernel.hpp.

#include "scene/scene.hpp"

namespace drench {

/// W(r) in three dimensions, zero at r ≥ h; 1/m³.
double kernel_value(KernelKind kernel, double r, double h);

/// Density ratio of a full cubic lattice of spacing d with h = support · d, 1.
double lattice_density(KernelKind kernel, double support);

/// (dW/dr)/r in three dimensions, zero at r ≥ h, r > 0; 1/m⁵.
double kernel_derivative(KernelKind kernel, double r, double h);

/// Relaxation ω of the pressure solves' Jacobi iteration: 0.9 over the largest eigenvalue of α A on a full lattice of
/// spacing d with h = support · d. A is the operator from κ to −Dδ/Dt; a wave κ ∝ cos(k·x) has λ(k) = |Σ_j ∇W_j
/// sin(k·x_j)|²/Σ_j |∇W_j|².
double jacobi_relaxation(KernelKind kernel, double support);

}  // namespace drench
