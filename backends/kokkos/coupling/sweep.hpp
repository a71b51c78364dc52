#pragma once
// Stage advection, laws 3 and 6: the liquid's paths.

#include "coupling/advection.hpp"

namespace drench::kokkos_backend {

/// Makes advection_work.ordered and .cluster_box, once, where cloth collides with itself.
void order_triangles(const Constants& constants, AdvectionWork& work);
/// Fills advection_work.end with x1 of each particle, .hit_* with what it hit, .hits with the number of hits at a node.
/// advection_work.start and .motion, the lists and the samples' cells are those of the step's start.
void sweep_paths(const Constants& constants, const Fluid& fluid, const NeighborLists& lists, const Cloth& cloth,
                 AdvectionWork& work, Real dt);

/// Law 6, second half: looks at the particles that a body's failsafe has moved away from advection_work.end.
void check_put_back(const Constants& constants, const Fluid& fluid, const NeighborLists& lists, const Cloth& cloth,
                    AdvectionWork& work);

}  // namespace drench::kokkos_backend
