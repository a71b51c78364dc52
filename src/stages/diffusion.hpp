#pragma once
// Stage diffusion: liquid spreads within the cloth (paper Eq. 11, replaced as physics.md section 9 says). Masses in
// quanta.
//
// Law.  For porous samples i, j of the same cloth and the same layer (|X_i − X_j| < 2h at rest) within h of each other:
//       κ_ij = 1 − r/h;  M2_i = Σ_j a_j κ_ij r_ij² (m⁴);  M2 = ½(M2_i + M2_j);
//       G_ij = 4 D · ½(C_i a_j + C_j a_i) κ_ij/M2, kg/s (0 if M2 = 0; a pair at r = 0 has κ = 1);
//       flux from j to i, kg/s: F_ij = G_ij [σ_ij (s_j − s_i) + σ_up (x_i − x_j)·ĝ/ℓ], ĝ = g/|g| (no second term if g =
//       0). linear: σ_ij = σ_up = 1. degenerate: σ_ij = ½(s_i + s_j), σ_up = s of the sample that the gravity term
//       leaves. D, ℓ, law: those of the cloth. (Sum over j of a_j κ r² … is the discrete second moment: it makes D the
//       diffusivity on any sampling.) Sub-steps n = max(1, ⌈Δt max_i rate_i/0.5⌉), rate_i = Σ_j G_ij (1 + |(x_i −
//       x_j)·ĝ|/ℓ)/C_i (1/s). In each: s_p = Σ_n w_pn m_n/C_n; o_ij = floor(|F_ij| Δt/(n q)) from donor to receiver, F
//       computed once per pair in the order lower index, higher index so that both sides round alike; limiter: out_p,
//       in_p = Σ of offers leaving/entering p; per node outflow_n = Σ_p w_pn out_p, inflow_n alike; φ^out_n = 1 if
//       outflow_n ≤ have, else have/outflow_n, with have = max(0, m_n − (outflow_n >> 16) − 1024); φ^in_n as in stage
//       absorption; φ_p = min over nodes with weight; transfer = o_ij if both φ = 1 else floor(o_ij min(φ^out_donor,
//       φ^in_receiver)). Net change of p (entering − leaving) goes to its nodes as in stage absorption (for a negative
//       change: the negative of the split of its magnitude).
// Momentum that moves with the diffusing liquid is neglected (its speed in the cloth is far below the cloth's own).
// Reads:  node_position, lists.   Writes: node_liquid; StepReport::diffusion_substeps.
