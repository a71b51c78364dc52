#pragma once
// Stage surface_tension: cohesion of the liquid, the smoothing of its surface, and adhesion to solids and cloth.
//
// After Akinci, Akinci & Teschner 2013, in volumes, so that every force is antisymmetric in its pair for any two masses
// (their −γ m_i (n_i − n_j) is not) and σ = `surface_tension` is in N/m. V_i = m_i/ρ0, x̂ = (x_i − x_j)/|x_i − x_j|.
//
// Laws. Force of liquid j on liquid i, N (Eqs. 1–4 of 2013; without their K_ij, which only makes σ depend on the density):
//         F_ij = −V_i V_j [ A C(r) x̂ + B (n_i − n_j) ]           0 for r ≤ 1e-9 h, both parts
//         C(r) = 32/(π h⁹) · { (h − r)³ r³  for r > h/2 ;  2 (h − r)³ r³ − h⁶/64  for r ≤ h/2 },   1/m³
//         n_i  = h Σ_j V_j ∇W_ij over liquid neighbours: toward the liquid, 0 inside, unit 1; W = the scene's kernel.
//       Force of a boundary sample b on liquid i, and −F_ib on the sample (cloth: on nodes f_n = Σ_b w_bn F_b; solids do
//       not move):
//         F_ib = −V_i V_b D_b a(r) x̂,   a(r) = 0.007/h³ · (−4 r²/h² + 6 r/h − 2)^¼  for h/2 < r < h, else 0,   1/m³
//         (their 0.007/h^3.25 (−4 r²/h + 6 r − 2 h)^¼); at cloth samples r as the pressure sees it (density.hpp).
//       v_i += Δt Σ F/m_i; nodes and pins as in stage forces.
//
// Why these are N/m. Let the liquid fill a half space evenly, and let pairs attract with V_i V_j f(r). Across the surface
// normal and tangential stress differ; the integral of the difference is the surface tension (Kirkwood & Buff 1949):
//         σ_A = (π/8) ∫ r⁴ A C(r) dr = 4 I₄ A h²,   I₄ = ∫₀¹ q⁴ c(q) dq = 7.45739e-4  (C = 32/(π h³) c(r/h))
//       The second part acts along the normal n(s) = h ∫ W dA at depth s, so that only the normal stress has a share:
//         σ_B = (B/2) ∬ π (h² − (s − s′)²) (n(s) − n(s′)) (s′ − s) ds ds′ over |s − s′| < h = k B h⁵,
//       k = 0.33973 (cubic), 0.34508 (wendland), 0.34219 (spiky, the gradient of poly6). It pushes the surface outward,
//       which is what lowers the pressure of the skin: positive tension. The share β of σ comes from it:
//         A = (1 − β) σ/(4 I₄ h²), N/m³;   B = β σ/(k h⁵), N/m⁶.
//       Cohesion also pulls inside the liquid, where it is an internal pressure that the density solve holds against:
//         P_i = (2π/3) ∫ r³ A C dr = 8.2313 (1 − β) σ/h, independent of the drop's size.  Field `pressure` contains it.
//       Adhesion: w = `adhesion` in N/m is the work per area that separates the liquid from the wall, so that by Young and
//       Dupré the contact angle has cos θ = w/σ − 1 (w = 2 σ wets completely). Samples d/2 behind the surface, V_L/d²
//       of volume per area, liquid beyond it:
//         w = D V_L/d² · 2π ∫_{d/2}^h a(r) G(r) dr,  G = r³/3 − d r²/4 + d³/48; the integral is 0.007 times
//         J = h M₃/3 − d M₂/4 + d³ M₀/(48 h²),  M₀ = 0.309012, M₂ = 0.179338, M₃ = 0.142780 (moments of (−4q²+6q−2)^¼)
//         D_b = w d²/(0.007 · 2π J V_L), N/m³; V_L = d³ for solids, 1/S for cloth (S = Σ W over a plane lattice: what
//         V_b of density.hpp is on a flat even sheet).
// Reads:  positions, masses, boundary volumes, lists.   Writes: fluid_velocity, node_velocity, node_pin_force.
