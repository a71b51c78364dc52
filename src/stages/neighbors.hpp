#pragma once
// Stage neighbors: who is within the support radius h of whom, at the positions of the step's beginning.
//
// Law:    docs/theory/liquid.md, Neighbours (r < h, strict; order of the lists); docs/theory/walls_and_sheets.md,
//         Pairs across a cloth (pairs fluid→fluid that are removed; off with `neighbors: {through_cloth: true}`).
// Lists:  fluid→fluid, fluid→boundary, fluid→sample, sample→fluid, sample→sample; of dynamic bodies boundary→fluid.
//         No particle is in its own list. Order: by cell, then by id (fluid) or index (samples), so sums are
//         reproducible.
// Reads:  fluid_position, boundary_position, node_position (m), fluid_id.
// Writes: the backend's neighbour lists.
// Errors: none. Lists grow when they overflow.
