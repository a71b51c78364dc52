#pragma once
// Stage density: boundary volumes, density ratio and Jacobi diagonal of both DFSPH solves.
//
// Notation: i, j liquid particles; b solid boundary samples and cloth samples alike ("boundary"); n cloth nodes;
// V_i = m_i / ρ0 (m³; m_i the ledger's mass), inverse node mass u_n = 1/m_n with m_n = m_s + m_f, u_n = 0 for pinned
// nodes.
//
// Laws. Akinci et al. 2012:  V_b = 1 / Σ_k W_bk over the samples k of the same kind, b included, unit m³:
//         solid samples: samples of the same body, computed once at set-up (a rigid motion keeps it);
//         cloth samples: all cloth samples, every step (the cloth deforms).
//       Density ratio (Bender & Koschier 2017):
//         δ_i = V_i W(0) + Σ_j V_j W_ij + Σ_b V_b W_ib                                            unit 1
//       Jacobi diagonal, exact for variable volumes (physics.md section 3), with a bound for the cloth:
//         1/α_i = |Σ_j V_j ∇W_ij + Σ_b V_b ∇W_ib|² + Σ_j V_i V_j |∇W_ij|² + Σ_b∈cloth V_b |∇W_ib| c_b     unit 1/m²
//         c_b = Σ_n w_bn u_n G_n,   G_n = Σ_b w_bn g_b,   g_b = V_b Σ_i m_i |∇W_ib|
//       The last term is the absolute row sum of the operator's cloth part. The exact diagonal (samples taken one by
//       one, as physics.md writes it) leaves out that many particles push the same light node: with mass ratios of
//       100:1 the Jacobi iteration then diverges; with the row sum it cannot (Gershgorin). α_i = 0 if 1/α_i < 1e-6/d²
//       or V_i = 0.
// Reads:  fluid_position, fluid_mass, node_position, node_liquid, boundary_volume, neighbour lists.
// Writes: fluid_density_ratio, sample_volume; α (the backend's own).
