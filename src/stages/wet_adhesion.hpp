#pragma once
// Stage wet_adhesion: wet fabric sticks to solids and to fabric (`porous.adhesion` > 0).
//
// w (N/m) is the work per area that parts two fabrics at saturation 1, or one of them from a solid: with a film of liquid
// between them 2σ cos θ, 0.14 N/m for water that wets both. A cohesive zone of constant traction (Dugdale 1960):
//       p = w s/a    as long as the gap is within a beyond contact,  a = max(τ, L̄/2),
// τ the fabric's thickness (m), L̄ the mean rest edge (m): a film parts over its own thickness, or over what the mesh
// resolves. Whatever a is, parting takes w s per area and peeling at a right angle w s per width (Rivlin 1944).
// physics.md has Akinci's kernel (2013) between samples instead. Its pull vanishes below half its range, so that sheets
// hang where it is largest, centimetres apart, and its range is that of the liquid's particles.
//
// Laws, for every node n of area A_n (a third of its triangles at rest), saturation s_n = min(1, m_f/C_n):
// 1. Solids: F_n −= (w s_n A_n/a) n for each body with φ(x_n + Δt v_s) < τ + a, φ its distance where it is at the step's
//    end, n the normal there, v_s its surface's velocity: the solid counts as wet as the fabric that touches it. Solids do
//    not feel it.
// 2. Fabric, of cloths with `self_collision`: node n and a triangle t none of whose corners is n or shares an edge with n,
//    τ the mean of their thicknesses, at a distance δ < τ + a: F = ½ (w_n s_n + w_t s_t)/a · ½ A_n along the way between
//    their nearest points, on n and with the opposite sign on t's corners by the weights b_k of its nearest point;
//    s_t = Σ b_k s_k. (½ A_n: the nodes of the other fabric stand for the same area.) Each node pulls at most two: the
//    nearest triangle, and the nearest of those that lie on its other side (δ⃗·δ⃗_first < 0). Ties: the least t.
// 3. v_n += Δt F_n/m_n, pins: node_pin_force −= F_n. Stages cloth and self_collision hold against it, so that it presses
//    what touches, and friction grows by μ w s/a per area.
// Momentum is conserved by law 2: impulses are 64-bit sums in units of q · 2^-20 m/s, exact in any order.
// Reads node_position, node_velocity, node_liquid; writes node_velocity, node_pin_force.
