#pragma once
// Stage advection: moves cloth and liquid; continuous collision of liquid against cloth; failsafes; the domain's
// border.
//
// Laws, in this order:
// 0. Coincident particles part: pairs of the list fluid→fluid closer than s = 1e-3 d at the start are set s apart, without
//    touching velocities:
//        shift_i = Σ_j m_j/(m_i + m_j) (s − r_ij) e_ij,   r_ij < s
//    e_ij = (x_i − x_j)/r_ij, and where r_ij < 1e-6 d the axis (id_i + id_j) mod 3, upwards for the higher id. The centre of
//    mass stays. Pressure does the rest (kernel.hpp).
// 1. Fresh particles (Origin::cloth, age < T = largest emission_ramp; Solenthaler & Gross 2011): with the nearest cloth
// sample p within h
//    (list fluid→sample, ties to the first), speed relative to v_p = Σ w_pn v_n is limited to u = d/T + 2 |g| age: free
//    fall is never cut, a kick is. The momentum removed goes to p's nodes: p_n += w_pn m_i Δv (fixed point, below).
// 2. Cloth: x_n += Δt v_n for free nodes, x_n = X(t + Δt) for pins that move (cloth.hpp); then projected out of bodies as in stage cloth; where that moved the node,
// the velocity into the body is removed
//    (v_n −= n min(0, (v_n − v_s)·n), v_s the surface's: bodies.hpp, law 3). Cloths with self_collision are not
//    projected here: their paths are free of intersections as stage self_collision leaves them.
// 3. Continuous collision (Bridson et al. 2002): liquid i moves x0 → x1 = x0 + Δt v_i + shift_i while triangles move linearly.
// Candidates: all triangles that can be hit, found as those that carry a
//    sample whose start position lies within x0 + [min(0, w − Δ⁺), max(0, w − Δ⁻)] grown by cover_radius · s + 1e-3 d: the path
//    w = x1 − x0 relative to the cloth, whose nodes' displacements lie between Δ⁻ and Δ⁺ (per axis: a point of the cloth that is
//    met at τ was at x0 + τ(w − Δ) at the start); s ≥ 1 = the largest singular value of any triangle's deformation at the start, as
//    cover_radius is measured at rest. Coplanarity is a cubic in τ ∈ [0, 1], all roots bracketed, in double; τ = 1 is always
//    tested, and counts as a root where x1 is no farther than 1e-6 d from the triangle's plane then; a hit has barycentric coordinates ≥ −1e-6, or is no farther from
//    the triangle's outline than 1e-6 of its longest edge (slivers, whose barycentric coordinates are rounding). The
//    earliest hit of all candidates moves x1, and the path from x0 to the new x1 is tested again. The first three times x1 keeps
//    what of its way goes along the sheet: it is lifted to g = 1e-2 d above the plane of the triangle's end, on the side on which
//    x0 was at the start. Where it is above that already, and the next three times, x1 := the hit point carried to the end of the
//    step with its triangle, g above it. If it still hits: x1 := the start position carried with the last triangle (barycentric
//    coordinates of the foot point, the start distance, at least g), and five more times at a quarter of the distance before:
//    a fold that closes leaves less room than g. (With the hit point alone, as Bridson et al. have it for
//    cloth, what slides along a sheet that moves stands still on it, is pressed by what follows, and takes up a velocity that it
//    never follows: 1 spacing a step, and five particles in the place of one, in a pool that fills at 0.6 of a spacing a step.)
//    Impulse: of the last hit, at its triangle and barycentric coordinates b, along n = the direction in which x1 was moved in all
//    (that of one lift is the triangle's normal; that of lifts off two planes leaves the way along their fold), with the relative
//    speed u = (v_i − v_hit)·n < 0:
//    J = −u / (1/m_i + Σ_k b_k² c_k/m_k) along n, c_k = number of particles that hit node k's
//    triangles in this step, pinned nodes 1/m_k = 0; v_i += J n/m_i; p_k −= b_k J n.
// 4. Bodies' failsafe: a particle behind a body's surface (φ < 0, at the step's end) goes back to the surface and
// loses its velocity into the body, relative to the surface.
// 5. x_i = x1; age_i += Δt. Outside the domain (or for cloth nodes: never) the particle is removed and its mass enters
// `drained`.
//    Removal keeps the order of those that stay.
// 6. What law 3 cannot stop is counted, not mended: StepReport::passed, the particles that end a step beyond a cloth that is
//    whole. It can happen in two ways, and the two are looked at: a particle that is still hit after the last repeat stays
//    on its last triangle, where another one may lie between (its path is tested once more); and law 4 moves particles after
//    law 3 (those that had cloth within h are tested on that way, against the triangles as they are at the end).
//    All others have a path that was found free. It is a warning: a run with a leaking fold is worth finishing.
// 7. StepReport::fled: at least 100 particles, and more than a quarter of all that there have ever been, left the domain in this
//    step. A warning, not a failure: a thin sheet of water may fall out of the domain at once. Liquid that pours over
//    the border takes many steps; liquid that explodes does not. With a particle that leaves at more than StepInfo::fluid_speed_limit
//    it is those that are so fast, and the run fails (pipeline/failure.hpp): they must not slip away into `drained`.
// Momentum for nodes is collected as 64-bit fixed-point sums in units of q · 2^-8 m/s and applied once, v_n += p_n u_n:
// exact in any order. Reads and writes: fluid_*, node_position, node_velocity; drained; StepReport::collisions,
// clamped, passed, lowest_passed, fled, fled_speed.
