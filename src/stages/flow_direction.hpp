#pragma once
// Stage flow_direction: where the liquid in the cloth wants to go (paper Eqs. 4–6, signs after physics.md section 6).
//
// Law.  P′_p = −k^p h Σ_b V_b ∇W_pb over solid samples b within h of the porous sample p (m/s²; points away from the
// solid: Darcy needs −∇P),
//       X = P′ + g,  v_p = X / (|X| + ε),  ε = 1e-3 |g| (if g = 0: ε = 1e-3 k^p; v_p = 0 if |X| = 0). No solid: P′ = 0.
//       Samples of cloths that are not porous: 0.
// Reads:  node_position, boundary_position, boundary_volume, lists sample→boundary.   Writes: sample_flow_direction.
