#pragma once
// Stage forces: gravity, the central field and viscosity on the liquid; the viscous reaction on cloth and dynamic
// bodies.
//
// Law:    docs/theory/viscosity.md: field (Eq. 1), pair forces and factors of walls (2, 3), stages of RKL1 (4 to 8).
//         Slip of walls (9 to 12): bodies and cloths with `slip`.
//         docs/theory/bodies.md: gravity and viscous reaction (7, 8). Gravity of the cloth belongs to stage cloth.
// Reads:  positions (m), masses (quanta), velocities (m/s), fluid_density_ratio (1), boundary_volume, sample_volume
//         (m³), lists; the scene's gravity (m/s²), field, `fluid.viscosity` (m²/s).
// Writes: fluid_velocity, node_velocity, body velocities (m/s, rad/s), node_pin_force (N);
//         StepReport::viscosity_stages (0 without viscosity).
// Errors: none. Neither viscosity nor the cloth's mass limits Δt.
