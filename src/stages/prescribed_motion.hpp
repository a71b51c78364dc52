#pragma once
// Stage prescribed_motion: the velocities that bodies with keys have over the step, so that they end it where their
// keys say.
//
// Law:    docs/theory/keys.md, Bodies (Eqs. 5, 6); of bodies that change their shape docs/theory/deforming_bodies.md
//         (3).
// Reads:  Model::bodies, time (s), Δt (s), boundary_position (m).
// Writes: body_position (m), body_orientation, body_velocity (m/s), body_angular_velocity (rad/s), boundary_velocity
//         (m/s), all of bodies with keys.
// Errors: none.
