#pragma once
// Stage advection, law 2: the cloth.

#include "coupling/advection.hpp"

namespace drench::kokkos_backend {

/// Moves the nodes; advection_work.start and .motion then say from where and how far, nodes.inverse_mass is fresh.
void move_cloth(const Constants& constants, const Fluid& fluid, const Bodies& bodies, Cloth& cloth, AdvectionWork& work,
                Real dt);

}  // namespace drench::kokkos_backend
