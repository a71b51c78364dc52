#pragma once
// Stage divergence: DFSPH's divergence-free solve (Bender & Koschier 2015, 2017), coupled to the cloth.
//
// Pressure acceleration (m/s²; κ in m²/s², pressure p = ρ0 κ); gradients at cloth samples as in density.hpp:
//     a_i = −Σ_j V_j (κ_i + κ_j) ∇W_ij − Σ_b 2 γ_ib V_b κ_i ∇W_ib
// A wall stands for the liquid mirrored in it: its pressure is that of the particle, κ_b = κ_i, and its normal velocity
//   relative to the wall the opposite, so that the particle meets it with 2 (v_i − v_b). With κ_b = 0, as Akinci et al. and
//   most codes have it, a layer at a wall needs twice the pressure of the next one to hold it off: 41 % of ρgH rms in a
//   column at rest, and particles pressed onto corners. Both factors are 2, so the operator stays symmetric.
// γ_ib = max(1, δ_i − 0.1) for cloth samples, 1 for solid ones: the mirrored liquid is as dense as the particle's
//   surroundings, but for the tenth by which these scatter: with max(1, δ_i) scatter feeds energy to light cloth.
//   With γ = 1 a sheet stands for one layer of liquid at rest; where the liquid on it is compressed, as under a wave that
//   breaks on a sheet giving way, a particle then lowers its density by moving into the sheet, its neighbours' pressure
//   drives it there, and only collision stops it: what has come to lie on the sheet gathers there without end (δ of 25
//   after 0.5 s). In front of its mirror image it gains nothing. (Solids hold with more layers of samples and a failsafe.)
//   (A flow along the wall is not mirrored: Σ_b V_b ∇W_ib has no tangential part on an even wall.)
// Force on a cloth sample F_b = Σ_i 2 γ_ib m_i V_b κ_i ∇W_ib (N), on a node f_n = Σ_b w_bn F_b, its acceleration
//     a_n = u_n (f_n − n min(0, f_n·n)) with n = direction of node_contact_force: a node that a solid supports is not
//     pushed into it; a_b = Σ_n w_bn a_n. Solid samples: a_b = 0, of dynamic bodies as bodies.hpp,
//     law 5, says.
//   Nodes answer with their inertia alone: this solve is an impact, in which velocities jump and elasticity has no time.
// Rate of compression (1/s), for velocities v_i, v_b (v_b = Σ_n w_bn v_n on cloth, boundary_velocity on solids):
//     R_i(v) = Σ_j V_j (v_i − v_j)·∇W_ij + Σ_b 2 γ_ib V_b (v_i − v_b)·∇W_ib      (= Dδ_i/Dt of the mirrored liquid)
//   minus Δt C_i κ_i, C_i (density.hpp) being a particle's compliance: 0 unless its neighbours are heavier. A light particle
//   cannot push full ones aside; held to the same bound it drives its own κ up until it is thrown away itself. So it yields
//   as if its diagonal were theirs. (A pool at rest with a fifth of its mass in particles of 5 %: 0.26 m/s rms and spray
//   of 3 m/s without, 0.07 and 0.6 m/s with it.)
// Problem: find κ_i ≥ 0 with  R_i(v + Δt a(κ)) ≤ 0, by relaxed Jacobi with Nesterov's momentum (1983):
//     κ⁺_i = max(0, κ_i + ω α_i R_i(v + Δt a(κ)) / Δt),    κ_i ← max(0, κ⁺_i + (θ − 1)/θ⁺ (κ⁺_i − κ⁻_i)),
//     θ⁺ = ½ (1 + √(1 + 4θ²)), θ = 1 at first, κ⁻ = the last κ⁺, at first κ.
//   (a(κ) lowers R_i by κ_i Δt/α_i to leading order, hence the sign.) The momentum is dropped, θ = 1, where the update
//   goes against it, Σ_i (κ_i − κ⁺_i)(κ⁺_i − κ⁻_i)/α_i > 0 (O'Donoghue & Candès 2015), or error + excess have grown.
//   ω = Model::relaxation (scene/smoothing_kernel.hpp); where error + excess exceed four times their smallest so far, it
//   is halved. A column of 20 layers takes 13 iterations to 1e-5 in place of more than 100.
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
