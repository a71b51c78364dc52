#pragma once
// The smoothing kernels, shared vocabulary of all stages (not a stage itself); `fluid.kernel` names one of them.
//
// Law:    docs/theory/liquid.md, Kernels: `cubic`, `wendland`, `poly6` (Eqs. 3 to 5), the gradient (6), and the
//         derivative between two liquid particles, held at its steepest (7). Which support: the table there.
// Units:  W in 1/m³, dW/dr in 1/m⁴, support h and distances in m. W(r) = 0 for r ≥ h; a pair is a neighbour if r < h.
// Errors: none here. The scene loader refuses h < 1.8 d; set-up warns of a lattice denser than 1.02.
