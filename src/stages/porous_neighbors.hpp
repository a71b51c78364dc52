#pragma once
// Stage porous_neighbors: the neighbour lists of the porous stages, at the positions after advection.
//
// Law.  As stage neighbors. Lists: fluid→sample, sample→sample, sample→boundary, within h. (fluid→sample where the cloth takes
//       or gives liquid; sample→sample there and with contact_wicking; diffusion within a cloth goes along its mesh.
//       sample→fluid has the same pairs as fluid→sample: the reference makes both, the Kokkos backend does not need it.)
//       A sample's position is Σ_n w_pn x_n.
// Reads:  fluid_position, boundary_position, node_position.   Writes: the backend's neighbour lists.
