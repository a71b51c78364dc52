#pragma once
// Stage surface_tension: surface tension of the liquid, and its adhesion to solids and cloth.
//
// After Akinci, Akinci & Teschner 2013 (cohesion, area term, adhesion), with central pair forces for any two masses, in
// volumes, so that linear and angular momentum are exact and σ = `surface_tension` is in N/m. V_i = m_i/ρ0,
// x_ij = x_i − x_j, x̂ its unit vector, W the scene's kernel.
//
// Laws. Force of liquid j on liquid i, N:
//         F_ij = V_i V_j [ A ∇W_ij − B/h² (1 − r²/h²) ((n_i − n_j)·x_ij) x_ij ],   r = |x_ij| < h
//         n_i  = h Σ_j V_j ∇W_ij over liquid neighbours (their Eq. 4): toward the liquid, 0 inside; unit 1.
//       Force of a boundary sample b on liquid i, and −F_ib on the sample (cloth: on nodes f_n = Σ_b w_bn F_b; solids do
//       not move):
//         F_ib = −V_i V_b D_b a(r) x̂,   a(r) = 0.007/h³ · (−4 r²/h² + 6 r/h − 2)^¼  for h/2 < r < h, else 0,   1/m³
//         (their 0.007/h^3.25 (−4 r²/h + 6 r − 2 h)^¼); at cloth samples r as the pressure sees it (density.hpp).
//       v_i += Δt Σ F/m_i; nodes and pins as in stage forces.
//
// Why not as printed. Their area term −γ m_i (n_i − n_j) is antisymmetric for equal masses only, and it is not central: a
//       drop that oscillates begins to spin (measured: after 1.6 periods 0.18 of Σ m |x||v|, up to 2e-3 a step; here 1e-7
//       and 1e-8). Its part along x̂ does the same work at a surface. Their cohesion kernel C(r) changes sign at short
//       range; with it a drop is a soft crystal: what oscillates is the lattice (ω² up to 2.5 times Rayleigh's) and it comes
//       to rest within a period. A ∇W is a negative pressure −A/2, which the pressure of the density solve, having
//       the same form, cancels pair by pair inside the liquid. Their K_ij = 2 ρ0/(ρ_i + ρ_j) only makes σ depend on
//       the density.
// Why these are N/m. Let the liquid fill a half space evenly, and let pairs attract with V_i V_j f(r). Across the surface
// normal and tangential stress differ; the integral of the difference is the surface tension (Kirkwood & Buff 1949):
//         σ_A = (π/8) ∫ r⁴ f dr = (π/2) A ∫₀^h r³ W dr = c A h,   f = −A dW/dr
//         c   = 31/560 (cubic), 5/96 (wendland), 3/56 (spiky, the gradient of poly6).
//       The area term between depths s and s′ = s + t under the surface, where n(s) = h ∫ W dA over the plane at distance s,
//       repels along x̂; of its stress the normal minus half of both tangential parts, (t² − ρ²/2)/h² with ρ² = r² − t²:
//         σ_B = B h⁵ ∫₀^1 t N(t) I(t) dt = k B h⁵,   N(t) = ∫₀^t n ds,   lengths in h,
//         I(t) = π ∫₀^{1−t²} (1 − t² − u)(t² − u/2) du = π [t² (1 − t²)²/2 − (1 − t²)³/12]
//         k    = 65441 π/11354112 = 0.018107 (cubic), 2557 π/443520 (wendland), 263 π/45760 (spiky).
//       It pushes the surface outward, which is what lowers the pressure of the skin: positive tension. With β = 0.78
//         A = (1 − β) σ/(c h), Pa;   B = β σ/(k h⁵), N/m⁶.
//       β balances the two at the surface. Where cohesion is too strong (β = 0.74) it compresses the skin, and the tension
//       is 1.07 … 1.13 of σ; where it is too weak (β > 0.85) it cannot hold the skin that the area term pushes out,
//       and the tension is lost. Measured in drop_test.cpp; there is no other constant that was fitted.
//       Cohesion is an internal pressure that the density solve holds against, independent of the drop's size:
//         P_i = A/2 = 1.99 σ/h (cubic).  Field `pressure` contains it.
//       Adhesion: w = `adhesion` in N/m is the work per area that separates the liquid from the wall, so that by Young and
//       Dupré the contact angle has cos θ = w/σ − 1 (w = 2 σ wets completely). Samples d/2 behind the surface, a layer of d
//       (m³ per m²; density.hpp) of them, liquid beyond:
//         w = D d · 2π ∫_{d/2}^h a(r) G(r) dr,  G = r³/3 − d r²/4 + d³/48; the integral is 0.007 times
//         J = h M₃/3 − d M₂/4 + d³ M₀/(48 h²),  M₀ = 0.309012, M₂ = 0.179338, M₃ = 0.142780 (moments of (−4q²+6q−2)^¼)
//         D_b = w/(0.007 · 2π J d), N/m³.
// Reads:  positions, masses, boundary volumes, lists.   Writes: fluid_velocity, node_velocity, node_pin_force.
