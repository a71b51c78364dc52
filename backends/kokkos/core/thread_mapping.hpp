#pragma once
// Where a GPU's threads run. Kernels rely on what Kokkos does and does not promise: the start of the backend looks at
// it once (docs/dev/portability.md has the list).

#include <cstdint>
#include <string>
#include <vector>

#include "core/types.hpp"

namespace drench::kokkos_backend {

/// Where an index of a kernel ran; −1: it did not.
struct ThreadPlace {
  int warp = -1;  // of the grid
  int lane = -1;  // of the warp
  int y = -1;     // threadIdx.y
};

/// What was seen of a GPU.
struct ThreadMapping {
  int warp_size = 0, team_size = 0;
  std::vector<ThreadPlace> loop, teams;  // of a loop's indexes; of all teams' threads, by rank
  std::uint64_t sum_order[2] = {0, 0};   // in which order a sum added its terms, twice
};

/// What kernels whose rows have `lanes` lanes cannot use, in one line; "" if nothing.
std::string mapping_fault(const ThreadMapping& seen, Index lanes);

/// The same of this GPU. Four small kernels, and the host waits for them. For CUDA alone.
std::string thread_mapping_fault();

}  // namespace drench::kokkos_backend
