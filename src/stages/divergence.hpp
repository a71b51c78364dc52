#pragma once
// Stage divergence: DFSPH's divergence-free solve (Bender & Koschier 2015, 2017); cloth and dynamic bodies answer in
// every iteration, cloth with its inertia alone.
//
// Law:    docs/theory/liquid.md: pressure operator (Eqs. 9 to 15), iteration and stopping (18 to 21), The divergence
//         solve. docs/theory/walls_and_sheets.md: mirrors (6, 7), extrapolated walls (7a to 7f), answer of the
//         cloth (17). docs/theory/bodies.md: (9, 10), held bodies (5, 5a).
// Reads:  positions (m), masses (quanta), velocities (m/s), node_contact_force (N), fluid_density_ratio, α, C, lists;
//         the scene's `fluid.solver`.
// Writes: fluid_velocity, node_velocity, body velocities (m/s, rad/s), node_pin_force (N), fluid_kappa_divergence
//         (m²/s²); StepReport::divergence_iterations, divergence_error (1), divergence_converged.
// Errors: none. A solve that ends at max_iterations is reported as not converged.
