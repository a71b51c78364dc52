#pragma once
// Stage porous_neighbors: the neighbour lists of the porous stages, at the positions after advection.
//
// Law:    docs/theory/porous.md, section 2: fluid→sample, sample→sample, sample→boundary, within h, as stage
//         neighbors. The reference makes sample→fluid too, which has the pairs of fluid→sample.
// Reads:  fluid_position, boundary_position, node_position (m).
// Writes: the backend's neighbour lists.
// Errors: none.
