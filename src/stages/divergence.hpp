#pragma once
// Stage divergence: DFSPH's divergence-free solve (Bender & Koschier 2015, 2017), coupled to the cloth.
//
// Pressure acceleration (m/s²; κ in m²/s², pressure p = ρ0 κ); gradients at cloth samples as in density.hpp:
//     a_i = −Σ_j V_j (κ_i + κ_j) ∇W_ij − Σ_b V_b κ_i ∇W_ib
// Force on a cloth sample F_b = Σ_i m_i V_b κ_i ∇W_ib (N), on a node f_n = Σ_b w_bn F_b, its acceleration
//     a_n = u_n (f_n − n min(0, f_n·n)) with n = direction of node_contact_force: a node that a solid supports is not
//     pushed into it; a_b = Σ_n w_bn a_n. Solid samples: a_b = 0, of dynamic bodies as bodies.hpp,
//     law 5, says.
//   Nodes answer with their inertia alone: this solve is an impact, in which velocities jump and elasticity has no time.
// Rate of compression (1/s), for velocities v_i, v_b (v_b = Σ_n w_bn v_n on cloth, boundary_velocity on solids):
//     R_i(v) = Σ_j V_j (v_i − v_j)·∇W_ij + Σ_b V_b (v_i − v_b)·∇W_ib                       (= Dδ_i/Dt)
// Problem: find κ_i ≥ 0 with  R_i(v + Δt a(κ)) ≤ 0, by relaxed Jacobi, ω = ½:
//     κ_i ← max(0, κ_i + ω α_i R_i(v + Δt a(κ)) / Δt).
//   (a(κ) lowers R_i by κ_i Δt/α_i to leading order, hence the sign.)
// Particles with fewer than 20 neighbours (liquid, solid and cloth samples together), or with α_i = 0, keep κ_i = 0 and
// are left out of the error. Warm start: half of the last step's κ; 0 where left out.
// One iteration = accelerations from κ, then R at all particles, the error, then κ's update.
// Error = (Δt / N) Σ_i max(0, R_i) over all N particles, measured with the κ that is applied in the end.
// Excess = (Δt / N) Σ_i e_i, e_i = 0 where R_i ≥ 0, else min(−R_i, κ_i Δt/(ω α_i)): pressure that is higher than needed
// and can still be taken back. Without it a warm start that pushes too hard counts as converged and feeds energy in.
// Stop: iterations ≥ min_iterations and error ≤ divergence_error and excess ≤ divergence_error; at max_iterations the
// solve ends and is reported. The update is not made after the last error.
// Then v_i += Δt a_i, v_n += Δt a_n, and pinned nodes' reaction: node_pin_force −= f_n.
// Reads:  positions, masses, velocities, node_contact_force, α, lists.
// Writes: fluid_velocity, node_velocity, node_pin_force, body velocities, fluid_kappa_divergence; StepReport::divergence_*.
