#pragma once
// Stage porous_neighbors: the neighbour lists of the porous stages, at the positions after advection.
//
// Law.  As stage neighbors. Lists: fluid→sample, sample→fluid, sample→sample, sample→boundary, within h. (sample→sample
//       where there is liquid or contact_wicking; diffusion within a cloth goes along its mesh.)
//       A sample's position is Σ_n w_pn x_n.
// Reads:  fluid_position, boundary_position, node_position.   Writes: the backend's neighbour lists.
