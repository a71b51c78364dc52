#include <algorithm>
#include <cstdlib>

#include "parallel/communicator.hpp"

namespace drench {

int started_ranks() {
  // Open MPI, MPICH and Intel MPI (Hydra), srun with PMI-2 or PMIx
  for (const char* name : {"OMPI_COMM_WORLD_SIZE", "PMI_SIZE", "PMIX_SIZE"})
    if (const char* value = std::getenv(name)) return std::max(1, std::atoi(value));
  if (std::getenv("PMIX_RANK") != nullptr || std::getenv("PMI_RANK") != nullptr)
    if (const char* value = std::getenv("SLURM_STEP_NUM_TASKS")) return std::max(1, std::atoi(value));
  return 1;
}

}  // namespace drench
