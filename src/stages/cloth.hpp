#pragma once
// Stage cloth: one implicit step of the cloth without the liquid's pressure: Projective Dynamics (Bouaziz et al. 2014)
// by Jacobi iterations with Chebyshev acceleration (Wang 2015), contact with bodies inside the iteration, Coulomb
// friction after it.
//
// It runs before the density solve (physics.md puts it after): elasticity is then part of the velocity that the
// pressure has to stop, the pressure solve sees cloth and liquid at the very velocities they move with, and water at
// rest on cloth is a fixed point.
//
// Law.  min_x Σ_n m_n |x_n − y_n|²/(2Δt²) + Σ_e (k_e/2) |x_i − x_j − d_e|² + Σ_h (c_h/2) |Σ_a K_a x_a|²
//       y_n = x⁰_n + Δt e^{−c Δt} v_n + Δt² g,  m_n = m_s + m_f (kg),  c = damping (1/s),
//       d_e = L_e (x_i − x_j)/|x_i − x_j| (0 if coincident), k_e (N/m), hinges with K and c_h (N/m). Start: x = y
//       (pinned: x⁰). Residual (a force, N): r_n = m_n/Δt² (y_n − x_n) − ∂(elastic energy)/∂x_n. Jacobi diagonal D_n =
//       m_n/Δt² + Σ_e k_e + Σ_h ½ c_h |K_n| Σ_a |K_a| (half the absolute row sum). Jacobi: x̂ = x + r/D, projected out
//       of bodies; Chebyshev: x^{k+1} = ω_{k+1} (x̂ − x^{k−1}) + x^{k−1}, then projected again; ω = 1 for the first 10
//       iterations, then 2/(2 − ρ²), then 4/(4 − ρ² ω). ρ = max_n (1 − m_n/(Δt² D_n)), a bound for the linear part.
//       Projection: a node whose distance φ to a body is below the cloth's thickness τ moves by (τ − φ) along the
//       body's normal (bodies in their order; boxes, spheres, planes). Every 10 iterations: residual = max over free
//       nodes |r_n|/D_n, nodes in contact without the part of r along the normal that presses into the body; stop at ≤
//       1e-5 × mean rest edge length. If it grew tenfold over the smallest so far, ρ is lowered (1 − 2(1 − ρ)) and ω
//       restarts at 1. Cap: 300 iterations. After it: v_n = (x_n − x⁰_n)/Δt; contact nodes (φ < 1.01 τ after the last
//       projection) store the body's normal in node_contact_normal (last such body in order), others 0; friction:
//       tangential speed relative to the body (at rest) falls by at most μ Δt r_press/m_n, r_press = max(0, −r·n).
//       Positions are not written: advection moves the nodes with the velocity that the density solve leaves.
//       Pins: node_pin_force −= elastic force + m_n g.
// Reads:  node_position, node_velocity, node_liquid.
// Writes: node_velocity, node_contact_normal, node_pin_force; StepReport::cloth_*.
