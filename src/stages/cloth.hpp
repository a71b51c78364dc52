#pragma once
// Stage cloth: one implicit Euler step of the cloth, contact with solids and Coulomb friction inside its iteration. It
// runs before the density solve and under the last step's pressure, so that water at rest on cloth is a fixed point.
//
// Law:    docs/theory/cloth.md. Springs and membranes, bending, strain damping and limits (2–5), wet material (6), pins
//         (7), Jacobi with Chebyshev weights (8), stopping rule (9), line search (10), contact and friction (11), XPBD
//         (12).
// Reads:  time (s), node_position (m), node_velocity (m/s), node_liquid (quanta); fluid_kappa_density (m²/s²) with the
//         inputs of its node forces (divergence.hpp); the scene's `cloth_solver` (method, tolerance, max_iterations).
// Writes: node_velocity (m/s), node_contact_force, node_friction_force, node_pin_force (N; 0 where nothing touches),
//         fluid_kappa_density (:= 0 where α = 0); StepReport::cloth_iterations, cloth_residual (1), cloth_converged.
//         body_velocity (m/s), body_angular_velocity, boundary_velocity of dynamic bodies (docs/theory/bodies.md, 14 to
//         16). Positions stay: stage advection moves the nodes with the velocity that the density solve leaves.
// Errors: none. A solve that ends at max_iterations is reported in StepReport, and its step may be shortened (10).
