#pragma once
// Stage absorption: the cloth takes up liquid (paper Eq. 7 after physics.md section 7). Masses in quanta, q = m0/2^32
// kg.
//
// Law.  For liquid i and porous sample j within h (r = |x_j − x_i|, V_i = m_i/ρ0):
//       s_j = Σ_n w_jn m_n/C_n (before the stage; a node with C_n = 0 counts 0);
//       c_ij = cos of the angle between x_j − x_i and the flow direction v_j (0 if v_j = 0 or r ≤ 1e-9 h);
//       cap = 1 + (s_max − 1) max(0, c_ij) (if v_j = 0: c_ij = 0);  deficit = max(0, cap − s_j).  Downstream of the
//       sample cap is 1, as the paper says of its (s_max − 1) cos θ. With (1 + c_ij)/2 in the place of max(0, c_ij) liquid
//       at the rim of the emission cone is taken up by the very sample that is giving to it.
//       L = 45 (h − r)/(π h⁶), 1/m⁵ (Müller et al. 2003);  wish w_ij = Δt k_a C_j deficit V_i L, kg.
//       Offer g_ij = T_i w_ij/Σ_k w_ik with T_i = m_i (1 − exp(−Σ_k w_ik/m_i)); quantised once: o_ij = floor(g_ij/q).
//       If 0 < m_i − Σ o_ij < m_min, the rest is added to the largest o_ij (first of equals): the particle is taken
//       whole. Node limiter: in_j = Σ_i o_ij; inflow_n = Σ_j w_jn in_j;  room_n = floor(s_max C_n/q) − m_n − (inflow_n
//       >> 16) − 1024 (the last two terms absorb rounding); φ_n = 1 if inflow_n ≤ room_n, else max(0, room_n)/inflow_n;
//       φ_j = 1 if φ_n = 1 for all of j's nodes with w_jn > 0, else Σ_n w_jn φ_n (the least of them, as first used,
//       lets a full node close its triangles, and every second node stays short of its capacity). Transfer t_ij = o_ij if φ_j = 1, else floor(o_ij φ_j). If a limiter
//       acted on i (φ_j < 1 for some o_ij > 0) and 0 < m_i − Σ t_ij < m_min, transfers are cut, in list order, until
//       exactly m_min stays (a particle that had less than m_min before gives nothing). m_i −= Σ_j t_ij; sample j
//       passes Σ_i t_ij on to its nodes by ŵ_jn = w_jn φ_n/φ_j (w_jn if φ_j = 1): floor(ŵ_jn t) each, the remainder to the
//       largest weight (first of equals).
//       Momentum: P_j = Σ_i t_ij v_i in fixed point (units q · 2^-8 m/s), node: v_n = (m_n v_n + Σ_j ŵ_jn P_j)/(m_n +
//       Δm_n); pinned nodes keep v = 0. A particle whose mass is 0 is removed, order kept (the reference: here; the
//       Kokkos backend: at the end of stage emission, or here if that is off).
// `processes: {direction: off}`: c_ij = 0, so cap = 1 on all sides.
// `processes: {saturation_control: off}`, part of the preset `baseline`: deficit = 1 whatever j holds, and φ_n = 1: a fixed
//       rate k_a C_j V_i L, without an upper bound of the saturation. Still on: what a particle has bounds what it gives, so
//       the ledger is as exact as ever; emission still begins at s_n = 1; what other stages bring to a node (emission c,
//       diffusion) keeps its limiter.
// Reads:  positions, lists, sample_flow_direction.   Writes: fluid_mass (and removal), node_liquid, node_velocity,
// fluid_velocity unchanged.
