#pragma once
// The smoothing kernel, shared vocabulary of all stages (not a stage itself); `fluid.kernel` names it.
//
// In 3-D with compact support h: W = 0 at r ≥ h, ∫ W dV = 1. With q = r/h in [0, 1], W in 1/m³, dW/dr in 1/m⁴:
// cubic     cubic spline (Monaghan 1992), σ = 8/(π h³):
//     W(r)  = σ · { 6 (q³ − q²) + 1   for q ≤ ½ ;  2 (1 − q)³   for q > ½ }
//     dW/dr = σ/h · { 6 q (3 q − 2)   for q ≤ ½ ;  −6 (1 − q)²  for q > ½ }
// wendland  C2 (Wendland 1995; in SPH Dehnen & Aly 2012), σ = 21/(2 π h³):
//     W(r)  = σ (1 − q)⁴ (4 q + 1),   dW/dr = −20 σ/h · q (1 − q)³
// poly6     Müller et al. 2003 (the paper's Eqs. 12, 13): the value of Poly6 and the gradient of another kernel, the
//           spiky one S = 15/(π h⁶) (h − r)³, because Poly6's own gradient vanishes at r → 0 and lets particles clump:
//     W(r)  = 315/(64 π h⁹) (h² − r²)³,   dW/dr := dS/dr = −45/(π h⁶) (h − r)²
//           Density and gradient belong to different kernels: Dδ/Dt of the divergence solve is not the rate of δ.
// Between two liquid particles dW/dr is held at its steepest below the distance where it is that (h/3 cubic, h/4 wendland,
// 0 poly6), after Thomas & Couchman 1992: the slope of a spline vanishes at r = 0, so that pressure does not hold apart what
// has come close: particles paired, light ones among full ones heaped up. Values stay as they are.
// ∇W_ij = dW/dr · (x_i − x_j)/|x_i − x_j|, the gradient in x_i: it points toward j. 0 for r ≤ 1e-9 h.
// A pair is a neighbour if r < h. Coincident particles are neighbours with W(0) and no gradient
// (stage advection parts them).
//
// Which h. A block starts as a lattice of spacing d, whose density ratio should be 1. Sums over the lattice:
//     h/d        1.2    1.5    1.8    2.0    2.3    2.5    3.0    4.0
//     neighbours 6      18     26     26     56     80     92     250
//     cubic      1.556  1.093  1.000  1.000  1.003  0.998  1.002  1.000
//     wendland   1.973  1.260  1.066  1.034  1.021  1.013  1.003  1.001
//     poly6      1.062  0.949  0.983  1.010  1.008  0.995  1.002  1.000
// Below h = 1.8 d a full neighbourhood has fewer than the 20 neighbours that stage divergence asks for: not allowed.
// Above 1.02 the block is compressed at the start and bursts: a warning (wendland wants h ≥ 2.4 d).
