#pragma once
// Stage evaporation: the free surface of the liquid loses vapour to the air. Masses in quanta.
//
// Law:    docs/theory/evaporation.md, section 4 (area of the surface), 5 (rounding; particles that are taken whole).
// Reads:  fluid_position, boundary_position (m), fluid_mass (quanta), boundary_volume, sample_volume (m³), lists of
//         stage neighbors; the scene's `air`.
// Writes: fluid_mass, evaporated (quanta). Particles of mass 0 are removed by stage advection. Velocities stay.
// Exact:  a particle is rounded by a number that its id and the step's have drawn.
// Errors: none.
