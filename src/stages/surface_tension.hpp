#pragma once
// Stage surface_tension: surface tension of the liquid (after Akinci, Akinci & Teschner 2013, as central pair forces in
// volumes), and its adhesion to solids and cloth, which pull as liquid does.
//
// Law:    docs/theory/surface_tension.md: cohesion and area term (Eqs. 1 to 3), their derivation (4 to 6), adhesion
//         and its contact angle (8 to 11). docs/theory/walls_and_sheets.md: beside walls that extrapolate (7e to 7g).
// Reads:  positions (m), masses (quanta), boundary_volume, sample_volume (m³), lists; `fluid.surface_tension` and
//         `adhesion` of bodies and cloths (N/m).
// Writes: fluid_velocity, node_velocity (m/s), node_pin_force (N); with such walls body_velocity (m/s),
//         body_angular_velocity (rad/s) of dynamic bodies.
// Errors: none here. The scene loader refuses adhesion to dynamic bodies; set-up warns of a fixed Δt beyond the
//         capillary limit.
