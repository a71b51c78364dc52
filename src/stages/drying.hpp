#pragma once
// Stage drying: porous cloth loses liquid to the air. Masses in quanta.
//
// Law:    docs/theory/evaporation.md, section 2 (rate and its exact integral), 3 (what covers a side), 5 (rounding).
// Reads:  fluid_position, boundary_position, node_position (m), fluid_mass (quanta), boundary_volume (m³), lists
//         fluid→sample (sample→fluid) and sample→boundary; the scene's `air`. The lists are there if the scene has
//         liquid.
// Writes: node_liquid, node_buffered (quanta; at most what the node holds then), evaporated (quanta). Velocities stay.
// Exact:  sums over liquid are 64-bit integers; a node is rounded by a number that its index and the step's have drawn.
// Errors: none.
