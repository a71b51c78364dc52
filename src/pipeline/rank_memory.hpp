#pragma once
// What one of many ranks takes in memory.

#include "setup/memory_estimate.hpp"

namespace drench {

/// The same as kokkos_array_bytes (pipeline/backend.hpp) for a rank that has `owned` of the scene's particles and
/// `ghosts` copies of others. Cloth and bodies count whole, and lists of cloth as if all of its liquid were this
/// rank's.
MemoryEstimate kokkos_rank_bytes(const SetupSize& scene, double owned, double ghosts, int real_bytes, bool gpu);

}  // namespace drench
