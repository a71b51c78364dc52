#pragma once
// Stage neighbors: who is within the support radius h of whom, at the positions of the step's beginning.
//
// Law.  j is a neighbour of i if |x_i − x_j| < h (strict); a particle is not its own neighbour; coincident particles
//       are neighbours. Lists: fluid→fluid, fluid→boundary, fluid→sample, sample→fluid, sample→sample.
// The same as stage porous_neighbors at the positions after advection, which adds sample→boundary.
// Order within a list is fixed: by cell, then by persistent id (fluid) or index (samples), so that sums are
// reproducible.
// Reads:  fluid_position, boundary_position, node_position.   Writes: the backend's neighbour lists.
