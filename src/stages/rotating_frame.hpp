#pragma once
// Stage rotating_frame: the centrifugal, Coriolis and Euler force of a frame that rotates about a fixed axis.
//
// Law:    docs/theory/rotating_frame.md: the accelerations (Eq. 1) and a step of them (2, 3).
// Reads:  time (s), fluid_position, node_position (m), fluid_velocity, node_velocity (m/s), node_liquid (quanta); the
//         scene's `rotating_frame`.
// Writes: fluid_velocity, node_velocity (m/s), node_pin_force (N).
// Errors: none. The Coriolis force turns velocities and never changes their size.
