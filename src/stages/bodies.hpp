#pragma once
// Stage bodies: the solids' poses and their samples at the end of the step. How bodies answer to forces is part of
// the stages forces, divergence and pressure.
//
// Law:    docs/theory/bodies.md: pose (Eq. 1), 1 prescribed motion (2, 3), 2 dynamic bodies and their contact (4, 5),
//         3 where solids stop cloth and liquid (6), 4 viscous reaction (7, 8), 5 answer to pressure (9, 10), 6 row
//         sums (11 to 13); 7 the CFL step: docs/theory/liquid.md (26). Samples and volumes:
//         docs/theory/walls_and_sheets.md (1 to 3). Bodies that change their shape: docs/theory/deforming_bodies.md.
// Reads:  Model::bodies, Model::boundary, time (s), body_position (m), body_orientation, body_velocity (m/s),
//         body_angular_velocity (rad/s).
// Writes: body_*, boundary_position (m), boundary_velocity (m/s), boundary_volume (m³) of bodies that change their
//         shape. Poses are double in every build.
// Errors: none. Bodies that change their shape stop no dynamic meshes. What cloth does to them: stages cloth
//         (14 to 16) and wet_adhesion.
