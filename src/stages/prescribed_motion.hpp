#pragma once
// Stage prescribed_motion: the velocities that bodies with keys, and bodies that a program moves, have over the step,
// so that they end it where they should be.
//
// Law:    docs/theory/keys.md, Bodies (Eqs. 5, 6); of bodies that change their shape docs/theory/deforming_bodies.md
//         (3); of commanded bodies docs/theory/bodies.md (2a), with the velocities of Eq. 6.
// Reads:  Model::bodies, time (s), Δt (s), boundary_position (m).
// Writes: body_position (m), body_orientation, body_velocity (m/s), body_angular_velocity (rad/s), boundary_velocity
//         (m/s), all of bodies with keys and of commanded bodies.
// Errors: none.
