#pragma once
// Stage bodies: prescribed motion of the solids' samples.
//
// Law.  Rotation about the body's centre c with constant angular velocity Ω = spin_rate · spin_axis (rad/s):
//       x_b(t) = c + Rot(spin_axis, spin_rate · t)(x_b(0) − c), v_b = Ω × (x_b − c), at t = time + Δt. Bodies without
//       spin keep x_b and v_b = 0. Always from the samples' positions at t = 0 (Model::boundary), so that errors do not
//       add up.
// Reads:  Model::boundary, time.   Writes: boundary_position, boundary_velocity.
