#pragma once
// Stage density: density ratio, volumes of the cloth's samples, and the Jacobi factors of both pressure solves.
//
// Law:    docs/theory/liquid.md: density ratio (Eq. 8), compliance C (16), Jacobi factor α (17).
//         docs/theory/walls_and_sheets.md: sample volumes (1), samples as the liquid sees them (5), density of the
//         image γ (7), factor L of extrapolated walls (7a to 7c), row sum of cloth (8, 9), contact factors α', C' and
//         which particles touch (12 to 14). docs/theory/bodies.md: row sums of dynamic bodies (12, 13), added where α >
//         0.
// Reads:  fluid_position, node_position (m), fluid_mass, node_liquid (quanta), boundary_volume (m³), neighbour lists.
// Writes: fluid_density_ratio (1), sample_volume (m³, while there is liquid); with time.mode error
//         StepReport::density_found (1, Eq. 27a); the backend's own α, α' (m²) and C, C' (1/m²).
// Errors: none. α = 0 marks particles without a usable diagonal; they carry no pressure.
