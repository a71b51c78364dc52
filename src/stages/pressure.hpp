#pragma once
// Stage pressure: DFSPH's constant-density solve (Bender & Koschier 2015, 2017), coupled to the cloth's implicit step.
//
// Notation and pressure accelerations as in stage divergence (divergence.hpp), κ being fluid_kappa_density.
// Predicted density ratio  δ_adv,i = δ_i + Δt R_i(v_i + Δt a_i(κ), v_n(κ)).
// Problem: find κ_i ≥ 0 with  δ_adv,i ≤ 1 + o_i − t(o_i),  o_i = max(0, δ_i − 1),  t(o) = max(o/2, min(c o, 0.1)),
//   c = density_correction in [½, 1], iterated as in stage divergence:
//     κ⁺_i = max(0, κ_i + ω α_i r_i/Δt²),  residual r_i = β_i (δ_adv,i − 1 − o_i + t(o_i))
//   With c = ½ half of the compression o that a step finds is taken back in it, the rest in the next ones: what a step pushes
//   apart leaves it as velocity, and with c = 1 (Bender & Koschier) a column at rest shakes itself (Baumgarte 1972 did so with
//   constraints). A flow that compresses by e a step, as what the rates leave out does in long steps, is found compressed by
//   e/c and left so by e (1 − c)/c: there c = 1 is the better. Of more than 0.2 it is half again: all of it would blow
//   particles apart that lie in each other.
//   β_i ∈ [0, 1] ramps a fresh particle's source in (Solenthaler & Gross 2011): β = min(1, age/T) for Origin::cloth
//   with T the largest emission_ramp of the cloths, 1 for all others. It multiplies the residual, both in the update
//   and in the error.
//
// Nodes' velocities. Nodes do not answer with their inertia alone: a sheet of 0.2 kg/m² under 100 kg/m² of water would
// then hold against it with M/Δt² instead of its stiffness K, a hundred times too little where Δt² K ≫ M, and the more
// the smaller Δt: energy from nothing as soon as Δt changes. So the cloth's step (cloth.hpp) goes on inside the solve.
// With u* = Δt v_n from stage cloth, f° its node forces and c_n = node_contact_force + node_friction_force:
//     m_n/Δt² (u*_n − u_n) + F_n(u) − F_n(u*) + f_n(κ) − f°_n − c_n + contact = 0,  v_n = u_n/Δt,
//   F = elastic and damping force; bodies as in stage cloth (they give c_n back where the node still touches).
//   Dynamic bodies answer in every iteration too (bodies.hpp, law 5).
//   In each iteration of κ the cloth's iteration runs in lots of 10, at most cloth_iterations_per_pressure(), until its
//   residual is ≤ 1.
//   (With looser limits the cloth lags behind κ, and the momentum overshoots.) Chebyshev's weights go on from one κ to
//   the next.
//   A scene whose cloths all stand still has fixed nodes instead.
//
// Liquid that touches a sheet. R_i lumps together what approaches the sheet and what the liquid does: where δ_i < 1, as in drops
//   and thin films, and where the liquid parts, the problem lets a particle go into a sheet on which it lies. Only collision
//   would stop it: an impulse to light nodes, which forget it in the next elastic step, so that the particle keeps its place and
//   a velocity into the sheet (a drop at rest on 0.2 kg/m²: 0.44 m/s; single particles of 90 m/s under a jet of 20). So a
//   particle that touches a sheet has a second pressure λ_i ≥ 0, between it and the sheets alone, with a problem of its own:
//     a_i −= Σ_b∈cloth 2 γ_ib V_b λ_i ∇W_ib,   F_b += Σ_i 2 γ_ib m_i V_b λ_i ∇W_ib,
//     R'_i = Σ_b∈cloth 2 γ_ib V_b (v_i − v_b)·∇W_ib − Δt C'_i λ_i,   residual β_i Δt R'_i ≤ 0,
//     λ⁺_i = max(0, λ_i + ω α'_i β_i R'_i/Δt),   1/α'_i = |g|² + C'_i + the cloth's row sum of 1/α_i (density.hpp),
//     g = Σ_b∈cloth 2 γ_ib V_b ∇W_ib,   C'_i = max(0, 0.1 (Σ_b∈cloth 2 γ_ib V_b |∇W_ib|)² − |g|²),
//   iterated with κ, with the same momentum; sums below are over both problems. Between sheets that close from two sides g
//   vanishes, and no velocity of the particle's would keep it off both: there it yields by C' (without, a light particle left a
//   fold at 235 m/s). Before a single sheet, up to 0.1 d from it, |g| is 0.54 to 0.62 of the sum of lengths, in a right-angled
//   fold 0.38: C' = 0. λ begins at 0 in each step. And δ_i of such a particle counts as 1 at least in its residual, though not
//   in what is reported: what rests on a sheet then has a κ_i, which has a warm start.
//   i touches if |(x_i − x_p)·n_p| < 0.1 d, p as in neighbors.hpp, where the foot of x_i on p's plane is nearer than 1.25 d to x_p
//   and not beyond the rim. Not with `through_cloth`.
//
// Particles with α_i = 0 keep κ = 0. Warm start: the last step's κ.
// Error = (1/N) Σ_i max(0, r_i) and excess as in divergence, (1/N) Σ_i e_i with r_i in place of R_i and κ_i Δt²/(ω α_i);
// α_i = 0 counts as β_i = 0, also in λ_i's residual; both add λ's terms. Order of operations and stopping as in divergence
// with the tolerance c density_error, which at rest leaves a mean compression of density_error at most; and the cloth's
// residual must be ≤ 1 too.
// Reported: mean and maximum of β_i max(0, δ_adv,i − 1), the compression that is left.
// Then v_i += Δt a_i, v_n as above; node_pin_force −= F_n(u) − F_n(u*) + f_n − f°_n.
// Reads:  positions, masses, velocities, fluid_age, fluid_origin, fluid_density_ratio, node_contact_force, α, lists.
// Writes: fluid_velocity, node_velocity, node_pin_force, fluid_kappa_density; StepReport::density_*, cloth_*.

#include <algorithm>

#include "scene/scene.hpp"

namespace drench {

/// How many iterations of the cloth an iteration of the pressure may take.
inline int cloth_iterations_per_pressure(const ClothSolverScene& solver) {
  return std::max(100, solver.max_iterations / 3);
}

}  // namespace drench
