#pragma once
// Stage pressure: DFSPH's constant-density solve (Bender & Koschier 2015, 2017), strongly coupled to the cloth.
//
// Notation and pressure accelerations as in stage divergence (divergence.hpp), κ being fluid_kappa_density.
// Predicted density ratio  δ_adv,i = δ_i + Δt R_i(v + Δt a(κ)).
// Problem: find κ_i ≥ 0 with δ_adv,i ≤ 1, by relaxed Jacobi, ω = ½:
//     κ_i ← max(0, κ_i + ω α_i β_i (δ_adv,i − 1)/Δt²)
//   β_i ∈ [0, 1] ramps a fresh particle's source in (Solenthaler & Gross 2011): β = min(1, age/T) for Origin::cloth
//   with T the largest emission_ramp of the cloths, 1 for all others. It multiplies the residual, both in the update
//   and in the error.
// Particles with α_i = 0 keep κ = 0. Warm start: the last step's κ.
// Error = (1/N) Σ_i max(0, β_i (δ_adv,i − 1)), error_max its largest term. Excess as in divergence: (1/N) Σ_i e_i with
// the residual β_i (δ_adv,i − 1) in place of R_i and κ_i Δt²/(ω α_i). Order of operations and stopping as in
// divergence. α_i = 0 counts as β_i = 0. Then v_i += Δt a_i, v_n += Δt a_n; node_pin_force −= f_n. Reads:  positions,
// masses, velocities, fluid_age, fluid_origin, fluid_density_ratio, node_contact_normal, α, lists. Writes:
// fluid_velocity, node_velocity, node_pin_force, fluid_kappa_density; StepReport::density_*.
