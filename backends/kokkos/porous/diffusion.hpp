#pragma once
// Stage diffusion: what stage porous_neighbors starts for it.

#include "porous/stages.hpp"

namespace drench::kokkos_backend {

/// The gravity terms and the largest rate of an explicit step, diffusion_work.drop and .rate, from the nodes'
/// positions. The host has to wait before it reads .rate.
void launch_diffusion_rate(const Constants& constants, Cloth& cloth, DiffusionWork& work);

}  // namespace drench::kokkos_backend
