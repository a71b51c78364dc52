#pragma once
// Stage cloth: the implicit step of the cloth: Projective Dynamics (Bouaziz et al. 2014) by Jacobi iterations with
// Chebyshev acceleration (Wang 2015), or the same step by XPBD (Macklin, Müller & Chentanez 2016), contact with bodies and
// Coulomb friction inside the iteration (as in Ly et al. 2020).
//
// It runs before the density solve (physics.md puts it after) and under the last step's pressure, so that water at
// rest on cloth is a fixed point; the density solve then goes on with the same iteration while its pressure changes
// (pressure.hpp).
//
// Law.  min_x Σ_n m_n |x_n − y_n|²/(2Δt²) + Σ_e (k_e/2) |x_i − x_j − d_e|² + Σ_h (c_h/2) |Σ_a K_a x_a|² + damping
//       y_n = x⁰_n + Δt e^{−c Δt} v_n + Δt² (g + f_n/m_n),  m_n = m_s + m_f (kg),  c = damping (1/s),
//       f_n = the node forces of fluid_kappa_density (divergence.hpp), with κ := 0 where α = 0 (N),
//       d_e = L_e (x_i − x_j)/|x_i − x_j| (0 if coincident), k_e (N/m), hinges with K and c_h (N/m).
//       Strain damping (Kelvin–Voigt; τ = strain_damping, s): Σ_e (k_e τ/(2Δt)) (e·(u_i − u_j))², u = x − x⁰,
//       e = direction of the edge at x⁰.
//       Strain limiting (`strain_limit` ε > 0): + Σ_t (w A_t/2) |F_t − F*_t|², F = [x1 − x0, x2 − x0] R⁻¹ (3 × 2; the rest
//       edges are Q R), F* = F with its singular values σ set to the nearest in [1 − ε, 1 + ε] (Bouaziz et al. 2014, sec.
//       5.1; 0 stays 0). w = 20 `stretch` (N/m): the modulus of a weave whose yarns are straight, some ten to fifty times that
//       at the start of its curve. So σ exceeds 1 + ε by (T − T_ε)/(w + stretch), T the tension (N/m), T_ε the springs' at
//       the limit: by 1 % at T − T_ε = 0.2 `stretch`.
//       Wet cloth: c and μ are linear in the node's saturation s = min(1, m_f/C_n), between `damping`, `friction` at s = 0
//       and `damping_wet`, `friction_wet` at s = 1. Fabric on solids: dry 0.3–0.5, wet 0.9–1.3.
//       Pins with prescribed motion: X(t) = C + v t' + Rot(axis, ω t')(X0 − C), t' = min(max(t, start), end) − start,
//       always from t = 0, so that errors do not add up. u = X(t + Δt) − X(t) in the solve; advection sets x = X(t + Δt).
//       Start: x = x⁰ + Δt e^{−c Δt} v (pinned: x⁰ + u): where the cloth goes by itself, and exact for cloth at rest.
//       Residual (a force, N): r_n = m_n/Δt² (y_n − x_n) − ∂(elastic energy and damping)/∂x_n.
//       Jacobi diagonal D_n = m_n/Δt² + Σ_e k_e (1 + τ/Δt) + Σ_h ½ c_h |K_n| Σ_a |K_a| + Σ_t ½ w A_t Σ_c |∂_c N_n| Σ_a |∂_c N_a|
//       (halves of absolute row sums, each column c of F a constraint; F* held, which only makes the energy larger).
//       Jacobi: x̂ = x + r/D, without what presses into bodies and with friction, projected out of bodies; Chebyshev: x^{k+1} = ω_{k+1} (x̂ − x^{k−1}) + x^{k−1}, then
//       projected again; ω = 1 for the first 10 iterations, then 2/(2 − ρ²), then 4/(4 − ρ² ω).
//       ρ = max_n (1 − m_n/(Δt² D_n)), a bound for the linear part, but at most 1/cosh(acosh(3)/(max_iterations − 10)). What k
//       iterations leave of a mode is p = T_k(λ/ρ)/T_k(1/ρ); a step that ends there goes on with x = a (2 x⁰ − x⁻¹),
//       a = (1 + p κ)/(1 + κ), κ the mode's Δt² stiffness/m, which grows without bound where a < −1/3. So |p| ≤ 1/3 within
//       the cap, and modes too slow for it (λ > ρ, where p is positive) are damped: a low cap makes cloth sluggish, not wild.
//       Projection: a node whose distance φ to a body is below the cloth's thickness moves by the difference along the
//       body's normal (bodies in their order, where they are at the step's end: bodies.hpp, law 3); by (τ − φ)/|∇φ| and two
//       more such steps, forth or back, where φ is a mesh's interpolated distance.
//       Friction: a node that touches bodies at x (φ < 1.01 thickness; normal n and surface velocity v_s of the last of them)
//       and is pressed into them by p = −Σ r·n > 0 (N) slips by t = x̂ − x⁰ − Δt v_s without its part along n; |t| falls by
//       at most μ p/D. Where the iteration rests |r_t| ≤ μ p, with equality against the slip if the node slips: Coulomb's
//       law, implicit.
//       method: xpbd iterates on multipliers instead, one force f_j (N) a constraint j, held at gradients g_jn:
//         springs f_e on their first node, g = ±1; hinges f_h, g = K_a; columns c of strain limits f_tc (N·m), g = ∂_c N_a;
//         x = Π(y + Δt²/m_n Σ_j g_jn f_j)
//         law of a constraint: F_e = −k_e (x_i − x_j − d_e) − k_e τ/Δt e e·(u_i − u_j),  F_h = −c_h Σ_a K_a x_a,
//         F_t = −w A_t (F − F*)
//         Jacobi: f̂ = f + θ (F(x) − f), then Chebyshev's ω on f as on x above. Start: f = F(x), unless its residual is
//         above 10 times that of f = 0, which is then taken: after a solve that ended at the cap F(x) is an explicit force.
//         That is XPBD's Δλ = −(C + α̃ λ)/(∇C M⁻¹ ∇Cᵀ + α̃), λ = Δt² f, α̃ = 1/(k Δt²), with a denominator large enough for
//         all constraints to move at once: θ_j = α̃/denominator = Σ_a |g_ja| / Σ_a |g_ja| q_a, q = Δt² D/m (1 if pinned).
//         It bounds the row sums of J M⁻¹ Jᵀ scaled by ½ k_j Σ_a |g_ja|, so the eigenvalues of the iteration lie within
//         ±(1 − min θ), and 1 − min θ ≤ ρ: the same ρ serves both methods, and both converge at the same rate.
//         C_e = x_i − x_j − d_e is a vector whose d_e is held while the multiplier moves, as in PD's local step. With
//         Macklin's |x_i − x_j| − L the multiplier turns with the edge, explicit in the tension, and that step diverges in
//         this Jacobi form and ends elsewhere by Gauss–Seidel (PHYSICS.md has the numbers).
//         Π: out of the half-spaces n·(x − x′) ≥ thickness − φ(x′), φ and n taken at the iterate x′ of the last check
//         (bodies in their order), then the projection as above. Without the contact's own force a pressed node lies deep
//         in the body, and its distance leads out elsewhere; normals that follow every iterate are a feedback that the
//         weights amplify. Friction as above at x′ with the way that is free instead of r/D.
//         The multipliers' forces cancel exactly, so cloth in free flight keeps its momentum whatever is left of r.
//       Every 10 iterations: residual = Σ |r_n| / Σ (tolerance m_n |y_n − x⁰_n|/Δt² + ½ ε D_n L̄) over free nodes, nodes in
//       contact without the part of r that presses into the bodies and without what friction holds; ε the precision's rounding, L̄ the
//       mean rest edge: below the second term sums of this precision are noise. Stop at ≤ 1. If it grew tenfold over
//       the smallest so far, ρ is lowered (1 − 2(1 − ρ)) and ω restarts at 1. Cap: max_iterations. A residual of 1
//       means that the unbalanced forces are `tolerance` times what moves the cloth: pins carry the weight to that.
//       Line search: a solve that ends at its cap may have led a cloth uphill in what it minimises, Φ. With u = x − x⁰ (pinned
//       nodes stay at their end), a = Σ r(x⁰)·u and b = Σ r(x)·u (J) over the cloth's free nodes, r(x) without the reaction of
//       bodies, Φ falls along u at x⁰ as a and still at x as b. If b < 0 the step is shortened to x⁰ + a/(a − b) u, the least of
//       Φ along it if r is linear (x⁰ where a ≤ 0). By the law, for convex energies, E(x) + ½ Σ m v² ≤ E(x⁰) + ½ Σ m v̂² −
//       ½ Σ m |v − v̂|² − b, v̂ = (y − x⁰)/Δt: energy does not arise. What it costs is momentum: such a cloth is slower than it
//       should be, as below the cap's ρ.
//       method, tolerance and max_iterations are the scene's `cloth_solver`.
//       After it: v_n = (x_n − x⁰_n)/Δt; node_contact_force = p n and node_friction_force, what friction takes of r; 0 for
//       nodes that touch nothing.
//       Positions are not written: advection moves the nodes with the velocity that the density solve leaves.
//       Pins: node_pin_force −= elastic and damping force + m_n g + f_n − m_n (u/Δt − v_n)/Δt; v_n = u/Δt (0 if they stand).
//       The work that pins do in a step is Σ node_pin_force · u.
// Reads:  time, node_position, node_velocity, node_liquid, fluid_kappa_density and what its forces need.
// Writes: node_velocity, node_contact_force, node_friction_force, node_pin_force, fluid_kappa_density (κ := 0); StepReport::cloth_*.
