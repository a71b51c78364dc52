#pragma once
// The smoothing kernel, shared vocabulary of all stages (not a stage itself).
//
// Cubic spline (Monaghan 1992) in 3-D with compact support h: W = 0 at r ≥ h. With q = r/h and σ = 8/(π h³), 1/m³:
//     W(r)      = σ · { 6 (q³ − q²) + 1   for q ≤ ½ ;  2 (1 − q)³   for q ≤ 1 }
//     dW/dr     = σ/h · { 6 q (3 q − 2)   for q ≤ ½ ;  −6 (1 − q)²  for q ≤ 1 }      1/m⁴
//     ∇W_ij     = dW/dr · (x_i − x_j)/|x_i − x_j|, the gradient in x_i: it points toward j. 0 for r ≤ 1e-9 h.
// A pair is a neighbour if r < h. Coincident particles are neighbours with W(0) and no gradient.
