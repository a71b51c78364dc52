// Stage self_collision in one kernel that stays on the device (self_collision_course.hpp): its passes are some hundred
// kernels of microseconds otherwise, and the host waits for their counts.

#include <cooperative_groups.h>

#include <algorithm>
#include <memory>

#include "cloth/self_collision_course.hpp"
#include "core/cuda/check.hpp"

namespace drench::kokkos_backend {
namespace {

namespace groups = cooperative_groups;

constexpr int block_threads = 512;

/// All threads of the device, a barrier after every law. The barrier is also what makes their writes seen.
struct WholeDevice {
  groups::grid_group grid;

  template <class Law>
  __device__ void each(const Collision& s, Index n) const {
    const auto threads = static_cast<Index>(gridDim.x * blockDim.x);
    for (Index i = static_cast<Index>(blockIdx.x * blockDim.x + threadIdx.x); i < n; i += threads) Law::act(s, i);
    grid.sync();
  }
  /// A block asks once.
  __device__ Index value(const Collision& s, CollisionCounter which) const {
    __shared__ Index number;
    if (threadIdx.x == 0) number = __ldcg(&s.counter.data[which]);
    __syncthreads();
    const Index seen = number;
    __syncthreads();
    return seen;
  }
};

__global__ void __launch_bounds__(block_threads, 1)
    run(const Collision s, CollisionProgress at, CollisionProgress* seen) {
  at = keep_apart(WholeDevice{groups::this_grid()}, s, at);
  if (blockIdx.x == 0 && threadIdx.x == 0) *seen = at;
}

}  // namespace

struct ResidentCollision {
  int most_blocks = 0;  // 0: it cannot be done
  Kokkos::View<CollisionProgress, Kokkos::SharedHostPinnedSpace> seen;
};

bool prepare_resident_collision(SelfCollisionWork& work) {
  if (work.resident == nullptr) {
    work.resident = std::make_shared<ResidentCollision>();
    const cudaDeviceProp& device = exec().cuda_device_prop();
    int at_once = 0;  // a processor
    if (device.cooperativeLaunch)
      check(cudaOccupancyMaxActiveBlocksPerMultiprocessor(&at_once, run, block_threads, 0), "self_collision");
    work.resident->most_blocks = std::min(at_once, 1) * device.multiProcessorCount;
    make_room_for_one(work.resident->seen, "drench::self_collision::progress");
  }
  return work.resident->most_blocks > 0;
}

CollisionProgress keep_apart_resident(SelfCollisionWork& work, const Collision& s, const CollisionProgress& at) {
  ResidentCollision& r = *work.resident;
  const int blocks = std::clamp(s.items / block_threads, 1, r.most_blocks);
  Collision collision = s;
  CollisionProgress progress = at;
  CollisionProgress* seen = r.seen.data();
  void* arguments[] = {&collision, &progress, &seen};
  const ExecSpace space = exec();
  std::uint64_t id = 0;
  Kokkos::Tools::beginParallelFor("drench::self_collision::resident", Kokkos::Tools::Experimental::device_id(space),
                                  &id);
  check(cudaLaunchCooperativeKernel(reinterpret_cast<const void*>(&run), dim3(static_cast<unsigned>(blocks)),
                                    dim3(block_threads), arguments, 0, space.cuda_stream()),
        "self_collision");
  Kokkos::Tools::endParallelFor(id);
  space.fence("drench::self_collision::resident");
  return r.seen();
}

}  // namespace drench::kokkos_backend
