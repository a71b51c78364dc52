#pragma once
// Stage advection, law 3: the liquid's paths.

#include "device.hpp"

namespace drench::kokkos_backend {

/// Fills advection_work.end with x1 of each particle, .hit_* with what it hit, .hits with the number of hits at a node.
/// advection_work.start and .motion, the lists and the samples' cells are those of the step's start.
void sweep_paths(Device& d, Real dt);

}  // namespace drench::kokkos_backend
