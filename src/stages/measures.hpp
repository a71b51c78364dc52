#pragma once
// Stage measures (`output: {measures: true}`): how clumped the liquid and how round the wet patch is. It changes nothing.
//
// Law.  r_i = the distance from liquid particle i to the nearest other one, of those that have one within h (which side of
//       a cloth it is on makes no difference).
//       nearest_variance = ⟨(r_i/d)²⟩ − ⟨r_i/d⟩², 1: 0 on a lattice, about 0.01 in liquid at rest; clumps and gaps raise it.
//       close_share = share of the particles, 1, that have another one nearer than half the sum of their radii, r_ij <
//       (d/4)(∛(m_i/m0) + ∛(m_j/m0)): d/2 for two full ones. (With d/2 for all of them liquid of which the cloth has
//       taken the most counts as clumped: its particles are small, and lie as near as their size lets them.)
//       wet_isotropy, 1: (u, v) = coordinates of a node in its cloth's rest plane, the plane through the centre of mass of
//       the rest shape along its two largest principal axes (of a grid: the grid's own plane; of a garment the one that it
//       is flattest in). M = Σ_n m_n (x − x̄)(x − x̄)ᵀ / Σ_n m_n, x = (u, v), x̄ its mean, with the liquid mass m_n = s_n C_n
//       as weight. Ratio of the smaller eigenvalue to the larger: 1 for a round or square patch, (b/a)² for an ellipse or a
//       rectangle of half axes a > b. Several porous cloths: the mean of theirs, weighted with the liquid that they hold. 0
//       where no cloth holds any, or all of it at one point (larger eigenvalue ≤ 1e-12 ⟨u² + v²⟩).
//       A cloth that is wet all over has the ratio of its own shape.
// Reads:  fluid_position, fluid_mass, node_liquid.   Writes: StepReport.
