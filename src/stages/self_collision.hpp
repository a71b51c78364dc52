#pragma once
// Stage self_collision: keeps the cloths that ask for it (`self_collision: true`) out of themselves and each other.
//
// It changes node velocities so that the nodes' straight paths x⁰ → x¹ = x⁰ + Δt v of this step are free of
// intersections. Pairs: a node and a triangle without it, and two edges without a common node (the one-ring is skipped).
// τ of a pair is the mean of its cloths' `thickness`, μ that of their friction at the saturation (cloth.hpp) of its first
// and last node. Nodes of other cloths take no part. Pins with prescribed motion have x¹ = X(t + Δt) (cloth.hpp).
//
// Laws, in this order; all arithmetic in double:
// 1. Bodies: where x¹ lies within a body, closer than the cloth's thickness, v := (projected x¹ − x⁰)/Δt, projected as in
//    stage cloth. The same after every change of v in law 3. Stage advection does not project these nodes again.
// 2. Conservative advancement (Mirtich 1996; Li et al. 2021) tells when a pair comes as near as η: with the four
//    displacements relative to their mean, l = max |of the first primitive's| + max |of the second's|, the distance δ
//    changes by at most l per unit of the step, so from t = 0 on
//        t += (δ(t) − η)/l   until δ(t) − η ≤ 0.01 η: reached at t, or t ≥ 1: not in this step
//    (reached, too, after 200 advances). No root is looked for and no degenerate case exists.
// 3. Contacts. Three rounds, each: a pair with δ⁰ ≤ τ is in contact at t = 0, one that reaches η = τ at that time; there
//    it has the unit normal n (to the first primitive) and the nearest points' weights: b = 1 for the node and −w for the
//    triangle; 1 − s, s and s′ − 1, −s′ for the edges. Wanted is the gap at the end
//        n·Σ_k b_k x¹_k ≥ θ,   θ = τ, but min(τ, δ⁰ + 0.1 τ) if δ⁰ < τ:
//    who starts too near parts slowly (Bridson et al. 2002). 8 Jacobi passes: λ := max(0, λ + Δλ),
//        Δλ = (θ − gap)/(Δt Σ_k b_k² c_k/m_k),   v_k += b_k Δλ n/m_k,
//    c_k = number of pairs with gap < θ or λ > 0 that node k (b_k ≠ 0) belongs to, pinned 1/m_k = 0. Sharing a node by c_k
//    makes the sum of impulses no larger than the largest of them asks for. Then Coulomb friction, once: of the relative
//    tangential speed u_t = (1 − n nᵀ) Σ b_k v_k the impulse min(μ λ, |u_t|/Σ b_k² c_k/m_k) is taken, c_k = pairs with λ > 0.
//    A round without contacts ends the rounds, and if it is the first, the stage.
// 4. Impact zones, the failsafe. A pair violates if it reaches η = min(τ/4, 0.8 δ⁰). Its four nodes join one zone (with
//    their zones). A zone moves as one: v := Σ m v/Σ m, plus what takes its nodes out of bodies: along each axis the
//    largest way up less the largest way down, over Δt. With pinned nodes it moves as the
//    first of them does, v := (X(t + Δt) − x⁰)/Δt, 0 for pins that stand. It stops, v := 0, if one of its pairs
//    violates all the same (rounding). All pairs are tested again until none violates. A zone can only
//    grow or stop, a pair at rest does not violate, so that this ends, and then no pair has come nearer than η > 0: what
//    starts without intersections stays without (x¹ is tested as rounded in the backend's precision). Before bodies:
//    a zone that they squeeze stays intersecting the body rather than itself. And before pins that are driven through
//    held cloth: a pair of a zone that has stopped is not tested again.
//
// Momentum is conserved by laws 3 and 4 (but for bodies, pins and zones that stop): impulses are 64-bit sums in units of
// q · 2^-20 m/s, zones' momenta and masses of q · 2^-12 m/s and q · 2^-16, exact in any order.
// Reads node_position, node_velocity, node_liquid; writes node_velocity; StepReport::cloth_contacts, cloth_zone_nodes.
