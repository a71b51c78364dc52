#pragma once
// Stage forces: gravity, the central field and viscosity on the liquid; the viscous reaction on the cloth.
//
// Laws. Gravity g (m/s²), and the scene's `field`: −Ω_k² (x − c)_k along each axis k, Ω in 1/s, c in m.
//       Viscosity, ν in m²/s, central pair forces (after Monaghan 2005; angular momentum is kept exactly) with the
//       weight |∇W|/r:
//         a_i = (χ ν/h²) [ Σ_j V_j/√(δ_i δ_j) (v_ij·x_ij) ∇W_ij + 2 Σ_b∈solids V_b/δ_i (v_ib·x_ib) ∇W_ib
//                          + 0.57 Σ_b∈sheets V_b/δ_i (v_ib·x_ib) ∇W_ib ]           (δ below 0.5 counts as 0.5)
//         χ = 30 h²/∫|∇W| r³ dV: 80/3 (cubic), 30 (wendland), 28 (poly6, the spiky gradient); then a linear or
//         quadratic velocity field gets ν Δv in the continuum. x_ib from the sheet's samples where they are.
//       (v_ij·x_ij < 0 for approaching particles and ∇W points toward j, so the force opposes the approach.)
//       m_i a_ij = −m_j a_ji also for unequal masses: both carry ρ0 V_i V_j/√(δ_i δ_j).
//       PHYSICS.md, "Viscosity", has the figures for the weight and the factors. 2: the samples of a solid lie as far
//       inside it as the first layer of liquid outside: to come to rest on the surface, liquid must feel a sample as if
//       it moved with −v (Morris, Fox & Zhu 1997). 0.57: makes the friction of the layers d/2, 3d/2 … on a plane sheet,
//       whose samples count for one layer, that of as many layers of liquid.
//       Reaction on a cloth sample: F_b = −Σ_i m_i a_ib; on nodes f_n = Σ_b w_bn F_b. Gravity of the cloth belongs to
//       stage cloth.
//
// Time. dv/dt = L(v) for particles and free nodes together, dv_i/dt = g + field + a_i, dv_n/dt = u_n f_n, at fixed
//       positions over Δt: s stages of the Runge–Kutta–Legendre method RKL1 (Meyer, Balsara & Aslam 2014),
//         Y_0 = v, Y_1 = Y_0 + w Δt L(Y_0), Y_k = (2k−1)/k Y_{k−1} − (k−1)/k Y_{k−2} + (2k−1)/k w Δt L(Y_{k−1}),
//         w = 2/(s² + s), the new v = Y_s; s = 1 is Euler's step. Written as changes D_k = Y_k − Y_{k−1} it is
//         D_k = (k−1)/k D_{k−1} + (2k−1)/k w Δt L(Y_{k−1}).
//       s is the smallest with  s (s + 1) ≥ 2 Δt max(max_i C_i, max_n u_n Σ_b w_bn K_b),  with
//         C_i = Σ of the factors (χ ν/h²) V/δ |∇W| r in a_i, K_b = Σ_i m_i (its part of C_i).
//       L is symmetric in the masses' inner product and its eigenvalues lie in [−2 max(…), 0], so the stages are stable
//       for every Δt, viscosity and mass of the cloth, never add kinetic energy, and keep what L keeps: momentum and
//       angular momentum. Water has s = 1.
//       Nodes carry impulses: J_k by the same recurrence from J_0 = 0 with w Δt f_n, v_n += u_n J_s;
//       pinned: node_pin_force −= J_s/Δt.
//       Dynamic bodies are stages too: bodies.hpp, law 4.
// Reads:  positions, masses, velocities, fluid_density_ratio, boundary_volume, sample_volume, lists.
// Writes: fluid_velocity, node_velocity, node_pin_force, body velocities.
