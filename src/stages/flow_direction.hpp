#pragma once
// Stage flow_direction: where the liquid in the cloth wants to go (paper Eqs. 4–6, signs after physics.md section 6).
//
// Law.  P′_p = −k^p h Σ_b V_b ∇W_pb over solid samples b within h of the porous sample p (m/s²; points away from the
// solid: Darcy needs −∇P); n = P′/|P′|. What stands against the flow is a reaction, so that it cannot push with more
// than it is pushed:
//       P^h = n min(|P′|, max(0, −g·n) + max(0, |g|/4 − |g_t|)),  g_t = g − (g·n) n  (if g = 0: P^h = P′),
//       X = P^h + g,  v_p = X / (|X| + ε),  ε = 1e-3 |g| (if g = 0: ε = 1e-3 k^p; v_p = 0 if |X| = 0). No solid: P′ = 0.
//       In contact the flow is thus tangent, and only on solids of less than 14° (|g_t| < |g|/4) does it turn away from
//       them. With all of P′ (Eq. 6 as printed; 2 to 4 g in contact at k^p = 16.8 m/s²) it leaves inclines of 30 to 90°
//       at 70°; with any constant it can be tangent at one slope only.
//       Samples of cloths that are not porous: 0. Stage emission takes all of P′ for the direction in which liquid leaves.
// `processes: {direction: off}`, part of the preset `baseline`: the stage does not run, there is no virtual pressure and
//       sample_flow_direction stays 0. This is another thing than a v_p that comes out as 0 (no gravity, no solid; such a
//       sample emits nothing): without directions absorption is unbiased (c_ij = 0), and emission has no cone: it gives to
//       liquid on all sides, solids do not block it, and new particles appear in the direction of gravity (absorption.hpp,
//       emission.hpp). So the paper's tables describe the method without it ("directional absorption: no", "flow-direction
//       check: no").
// Reads:  node_position, boundary_position, boundary_volume, lists sample→boundary.   Writes: sample_flow_direction.
