#pragma once
// Stage diffusion: liquid spreads within the fabric (paper Eq. 11, replaced as PHYSICS.md says), and passes between
// layers that touch where `porous.contact_wicking` asks for it. Masses in quanta.
//
// Within a cloth, between its nodes, which hold the liquid:
// 1. Conductance G_ij = ρ0 (1−Φ) τ D ω_ij, kg/s, ω_ij = ½ (cot α_ij + cot β_ij) ≥ 0 (Model::fabric): the angles opposite to
//    an edge of the rest shape's intrinsic Delaunay triangulation (Bobenko & Springborn 2007), whose edges run within the
//    fabric. It is the finite-element (and finite-volume) Laplacian: exact for linear s on any mesh and up to its rims,
//    and D (m²/s) is the diffusivity. ω counts as 0 on edges of the rim opposite to an obtuse angle, the only ones below 0,
//    and as 100 where it is above: between nodes that nearly coincide.
//    C_n = (1−Φ) τ ρ0 · a third of the node's triangles. Pairs with a node of C_n = 0 conduct nothing.
// 2. Flux from j to i, kg/s: F_ij = −F_ji = G_ij σ_ij b_ij,  b_ij = (s_j − s_i) + (x_i − x_j)·ĝ/ℓ,  ĝ = g/|g|; without
//    gravity b has no second term. x are the positions now: at rest s falls by 1 over the height ℓ.
//    linear: σ = 1. degenerate (the paper's factor m_f): σ_ij = min(½(s_i + s_j), 2 s_donor), the donor being the node that
//    b leaves: a dry node gives nothing.
// 3. Sub-steps n = max(1, ⌈Δt max_i rate_i/0.5⌉), rate_i = Σ_j G_ij (ς + |(x_i − x_j)·ĝ|/ℓ)/C_i (1/s), ς = 1 (linear) or
//    s_max (degenerate). In each: s_n = m_n q/C_n; o_ij = floor(|F_ij| Δt/(n q)), once a pair, from donor to receiver;
//    per node out_n, in_n = Σ of offers; φ^out_n = 1 if out_n ≤ have, else have/out_n, with have = max(0, m_n −
//    (out_n >> 16) − 1024); φ^in_n as in stage absorption; transfer = o_ij if both φ = 1 else floor(o_ij min(φ^out_donor,
//    φ^in_receiver)). Without gravity no s_n leaves the range of its neighbours'.
//
// Between layers, both of cloths with contact_wicking, after each sub-step of 3 (of another cloth or of the same one):
// 4. Sample p sees the nearest triangle t on each side of its own (ties: the least t) of those that carry a sample within h
//    of it and share no node with its triangle: nearest point f = Σ b_k x_k, d = x_p − f, 0 < |d| ≤ 1.5 τ̄ and
//    |d·n_p| ≥ |d|/√2, τ̄ the mean of the two thicknesses, n_p the normal of p's triangle; the side is the sign of d·n_p.
// 5. G = ½ a_p K, K = 1/(½ τ_p/(ρ0 (1−Φ_p) D_p) + ½ τ_t/(ρ0 (1−Φ_t) D_t)), kg/(m² s): half of each layer in series, both
//    layers' samples counting half. K ≤ ¼ ρ0 min((1−Φ) τ) n/Δt: thin layers come to equal within a few (sub-)steps
//    instead of asking for more of them. Flux from f to p: F = G σ [(s_f − s_p) + (x_p − x_f)·ĝ ½(1/ℓ_p + 1/ℓ_t)],
//    s_p = Σ w_pn s_n, s_f = Σ b_k s_k, σ as in 2 (degenerate if either cloth is).
// 6. o = floor(|F| Δt/(n q)); its part for node k is floor(w_k o), the remainder to the largest weight. Per node out_n, in_n =
//    Σ over the contacts of floor(w_k o) + 1; φ as in 3; transfer = floor(o min over the donor's and receiver's nodes with
//    weight of φ^out, φ^in).
// 7. Between sub-steps reservoirs are filled up as in stage reservoir, so that what they supply does not depend on Δt.
// 8. Liquid takes its donor's velocity along: v_n' = v_n + Σ_in t (v_donor − v_n)/M_n', M_n' (kg) the node's solid and liquid
//    after the exchange, donors' velocities those before it; once for 3 and once for 4–6 of each sub-step. Out of a contact
//    v_donor = Σ t_k v_k/Σ t_k over the donor's nodes. It is the sum Σ t v of what enters, written so that v_n' is a mean of
//    the v: Σ M v over nodes that are free stays the same. Pinned nodes keep their velocity (theirs goes to the pins). What
//    reservoirs supply comes with their node's velocity. Nothing of it runs where no cloth that moves has a diffusivity.
// More than 10^6 sub-steps in 3 end the run (src/pipeline/substeps.hpp).
// Reads:  node_position, node_velocity, lists.   Writes: node_liquid, node_velocity, supplied; StepReport::diffusion_substeps.
