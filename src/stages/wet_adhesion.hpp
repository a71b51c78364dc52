#pragma once
// Stage wet_adhesion: wet fabric sticks to solids and to other wet fabric (`porous.adhesion` > 0, a work in N/m).
//
// Law:    docs/theory/wet_adhesion.md. 1 solids, at the samples; 2 fabric (cloths with `self_collision`), at nodes; 3
//         velocities and pins.
// Reads:  node_position (m), node_velocity (m/s), node_liquid (quanta).
// Writes: node_velocity (m/s), node_pin_force (N); body_velocity (m/s), body_angular_velocity (rad/s) of dynamic
//         bodies.
// Exact:  impulses of 2 are 64-bit sums in units of q · 2^-20 m/s.
// Errors: none.
