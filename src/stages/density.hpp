#pragma once
// Stage density: boundary volumes, density ratio and Jacobi diagonal of both DFSPH solves.
//
// Notation: i, j liquid particles; b solid boundary samples and cloth samples alike ("boundary"); n cloth nodes;
// V_i = m_i / ρ0 (m³; m_i the ledger's mass), inverse node mass u_n = 1/m_n with m_n = m_s + m_f, u_n = 0 for pinned
// nodes.
//
// Laws. Boundary volumes after Akinci et al. 2012, unit m³: V_b = d³ S / Σ_k W_bk over samples k, b included; of solids
//         those of the same body, computed once at set-up (a rigid motion keeps it); of cloth all, every step (it
//         deforms). S = Σ_{a,b} W(d √(a² + b²)) over a plane square lattice, so that a plane of samples at the spacing
//         counts for exactly the one layer of liquid that the wall replaces. (With 1/Σ W it counts for 1.43 of it: a
//         lattice at rest on a wall starts with δ = 1.06 there, 1.15 in corners, and jumps.)
//       A sheet is a wall on whichever side the particle is: for a cloth sample the kernel and its gradient are taken at
//         r_ib = x_i − x_b + ½ d n_b sign((x_i − x_b)·n_b)   (sign(0) = 1), n_b = unit normal of the sample's triangle,
//       that is, with the sample half a spacing behind the surface, where those of solids lie too. With the samples on
//       the surface the kernel sum of a sheet has no slope there: liquid that came close was not pushed back, stuck,
//       and its pressure grew without bound.
//       Density ratio (Bender & Koschier 2017):
//         δ_i = V_i W(0) + Σ_j V_j W_ij + Σ_b V_b W_ib                                            unit 1
//       Jacobi diagonal, exact for variable volumes (physics.md section 3), with a bound for the cloth:
//         1/α_i = |Σ_j V_j ∇W_ij + 2 Σ_b γ_ib V_b ∇W_ib|² + Σ_j V_i V_j |∇W_ij|² + C_i
//                 + 0.16 Σ_b∈cloth 4 γ_ib² V_b |∇W_ib| c_b   unit 1/m²
//         γ_ib = max(1, δ_i − 0.1) for cloth samples, 1 for solid ones: how dense the mirrored liquid is (stage divergence)
//         c_b = Σ_n w_bn u_n G_n,   G_n = Σ_b w_bn g_b,   g_b = V_b Σ_i m_i |∇W_ib|
//       The last sum is the absolute row sum of the operator's cloth part, for nodes with inertia alone. The exact
//       diagonal (samples taken one by one, as physics.md writes it) leaves out that many particles push the same light
//       node: with mass ratios of 100:1 the Jacobi iteration then diverges. With relaxation ω a share ω/2 of the row sum
//       bounds it (Gershgorin; the other particles' γ taken for i's own), and ω is at most 0.32 where h ≥ 2 d. The factors 2 and
//       4: stage divergence.
//       Dynamic bodies add their own row sum (bodies.hpp, law 6) where α_i > 0.
//         C_i = Σ_j max(0, V_j − V_i) V_j |∇W_ij|²: compliance of a particle among heavier ones (stage divergence), unit 1/m².
//       α_i = 0 if 1/α_i < 1e-6/d² or V_i = 0. Of liquid that touches a sheet α'_i and C'_i likewise (stage pressure).
// Reads:  fluid_position, fluid_mass, node_position, node_liquid, boundary_volume, neighbour lists.
// Writes: fluid_density_ratio, sample_volume; α, C, α', C' (the backend's own).
