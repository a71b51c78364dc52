#pragma once
// Stage advection, law 2: the cloth.

#include "device.hpp"

namespace drench::kokkos_backend {

/// Moves the nodes; advection_work.start and .motion then say from where and how far, nodes.inverse_mass is fresh.
void move_cloth(Device& d, Real dt);

}  // namespace drench::kokkos_backend
