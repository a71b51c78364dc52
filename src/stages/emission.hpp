#pragma once
// Stage emission: the cloth gives back what it holds above capacity (paper Eqs. 9–10 after physics.md section 8).
// Masses in quanta.
//
// Ripening. Excess e_n = max(0, m_n − C_n) (C_n in quanta, floor). The paper's rate limit 1 − exp(−u_e Δt/d) acts on a
// store: ripe_n ← min(e_n, ripe_n),
//   then ripe_n ← ripe_n + floor((1 − exp(−u_e Δt/d)) (e_n − ripe_n)). Only ripe liquid leaves. (Limiting each step's
//   amount alone would keep it below m_min for ever: a thin fabric then never drips. ripe_n is a part of m_n, not extra
//   mass.)
// Share of sample p (porous; w′_n of Eq. 9): E_pk = floor(w_pk ripe_k/w′_k) for its three nodes k, E_p = Σ_k E_pk (Eq.
// 10). Its velocity
//   v^e_p = Σ_k E_pk v_k/E_p: leaving liquid takes exactly its nodes' momentum. Direction
//   e_p = v_p = sample_flow_direction where no solid sample is within h, else Y/(|Y| + ε), Y = P′ + g with P′ and ε of
//   flow_direction.hpp: what leaves goes away from the solid, also where the flow within the cloth is tangent to it (a
//   cone of 80° about a tangent always sees the solid: cloth on a slope could never drip). v_p = 0 emits nothing.
//   "In the cone": angle between x − x_p and e_p below θ^e, i.e. cos > emission_cosine (r ≤ 1e-9 h: not in the cone).
//   Neighbours within h.
// In this order:
// (a) To liquid j in the cone with m_j < m_max: room R_j = m_max − m_j, offer o_pj = floor(E_p R_j/Σ_j R_j); O_j = Σ_p
// o_pj; accepted t_pj = o_pj if
//     O_j ≤ R_j, else floor(o_pj (R_j/O_j)(1 − 1e-9)). m_j += Σ_p t_pj, v_j the mass-weighted mean of v_j and v^e_p.
//     Rest E′_p = E_p − Σ_j t_pj.
// (b) A solid sample in the cone: nothing more leaves p (neither c nor d).
// (c) To porous samples q in the cone of another layer (another cloth, or the same cloth with |X_p − X_q| ≥ 2h at
// rest): offer floor(E′_p/k) to
//     each of the k such q, limited by the receiving nodes' room as in stage absorption (φ_q); E″_p = E′_p − accepted.
//     Momentum moves with v^e_p.
// (d) A new particle. Samples of a layer pool what they have left: every p points to the one of itself and its porous
// neighbours of the same layer
//     (not another layer in the sense of c; not blocked by b; E″ > 0) that has the largest E″ (ties: the lowest index).
//     A sample that points to itself is a collector; p gives to the sample it points to if that is a collector. A
//     collector whose sum S ≥ m_min is a candidate with mass min(S, m_max) and position x_p + (d/2)(1 + cbrt(mass/m0))
//     e_p. It is created unless a liquid particle, or a candidate of a collector with a lower index, is closer than d/2
//     to that position, or the position lies inside the liquid: Σ_j V_j W(x − x_j) > ½ (a plane surface has ½). A cloth
//     that lies in a pool would else press particles into the gaps of the liquid below it, and pump for ever. Samples with a porous
//     sample of their own layer ahead, within 30° of e_p, take no part: the fabric there is steeper than 60°, and the
//     particle would appear within it. Liquid runs on inside and drips at the hem. If S > m_max each giver's part is cut to floor(E″ m_max/S) and the mass is the sum of the
//     parts. Velocity: Σ part v^e / mass. Age 0, Origin::cloth, κ = 0; new ids in the order of the collectors' indices,
//     appended. (Pooling makes dripping independent of the sampling: as printed, one sample of area d² holds less than
//     m_min above capacity if the fabric is thinner than about d/2.)
// (e) The rest stays on its nodes.
// What p gave in total, U_p ≤ E_p, leaves its nodes as floor(U_p E_pk/E_p), the remainder from its nodes in order 0, 1,
// 2 while they have E_pk left; ripe_n falls by the same. Node velocities stay. Momentum received by nodes in (c): as in
// stage absorption. After the stage fluid particles are not removed.
// `processes: {direction: off}`: there is no cone. In (a) and (c) everything within h is in it (r > 1e-9 h), (b) blocks
//       nothing, every porous sample emits, and in (d) ĝ/1.001 (g/|g|, as v_p would be without a solid) stands for v_p;
//       without gravity there is no (d).
// Reads:  positions, lists, sample_flow_direction, velocities.
// Writes: node_liquid, node_ripe, node_velocity (c), fluid_mass, fluid_velocity, fluid_* appended, next_id.
