#pragma once
// Stage forces: gravity and viscosity on the liquid; the viscous reaction on the cloth.
//
// Laws. Gravity g (m/s²). Viscosity, Laplacian form (Monaghan 2005; Weiler et al. 2018, d = 3), ν in m²/s:
//         a_i += 10 ν Σ_j (2 V_j/(δ_i + δ_j)) (v_ij·x_ij)/(|x_ij|² + 0.01 h²) ∇W_ij
//              + 10 ν Σ_b V_b/δ_i (v_ib·x_ib)/(|x_ib|² + 0.01 h²) ∇W_ib            (δ below 0.5 counts as 0.5)
//       (v_ij·x_ij < 0 for approaching particles and ∇W points toward j, so the force opposes the approach.)
//       Reaction on a cloth sample: F_b = −Σ_i m_i a_ib; on nodes f_n = Σ_b w_bn F_b; v_n += Δt u_n f_n; pinned:
//       node_pin_force −= f_n. v_i += Δt a_i, all a_i from the velocities before the stage. Gravity of the cloth
//       belongs to stage cloth.
//       Dynamic bodies: bodies.hpp, law 4.
// Reads:  positions, masses, velocities, fluid_density_ratio, lists.   Writes: fluid_velocity, node_velocity,
// node_pin_force, body velocities.
