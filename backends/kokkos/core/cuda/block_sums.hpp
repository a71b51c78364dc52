#pragma once
// Sums over the blocks of a kernel of CUDA's own, always in the same order.

#include <cstring>

#include "core/types.hpp"

namespace drench::kokkos_backend {

inline constexpr unsigned all_lanes = 0xffffffff;

/// The sum over a warp, in its first lane.
template <class Sums>
__device__ __forceinline__ Sums sum_of_warp(Sums s) {
  constexpr int words = sizeof(Sums) / sizeof(unsigned);
  for (int apart = warp_size / 2; apart > 0; apart /= 2) {
    unsigned word[words];
    memcpy(word, &s, sizeof(Sums));
#pragma unroll
    for (int k = 0; k < words; ++k) word[k] = __shfl_down_sync(all_lanes, word[k], apart);
    Sums other;
    memcpy(&other, word, sizeof(Sums));
    s += other;
  }
  return s;
}

/// Adds up what the blocks of a kernel, or of several that follow each other, have, always in the same order.
template <class Sums, int threads>
struct BlockSums {
  Sums* part;   // of each block
  Sums* total;  // where the host reads it
  unsigned* finished;
  unsigned first, blocks;  // of this kernel, among all of them; their number

  /// The sum over a block, in its first thread; `own` is that of a warp, in its first lane.
  __device__ Sums over_block(Sums s) const {
    __shared__ Sums room[threads / warp_size];
    if (threadIdx.x % warp_size == 0) room[threadIdx.x / warp_size] = s;
    __syncthreads();
    if (threadIdx.x == 0)
      for (int w = 1; w < threads / warp_size; ++w) s += room[w];
    __syncthreads();
    return s;
  }
  __device__ Sums seen(unsigned block) const {
    constexpr int words = sizeof(Sums) / sizeof(double);
    double word[words];
#pragma unroll
    for (int k = 0; k < words; ++k) word[k] = __ldcg(reinterpret_cast<const double*>(part + block) + k);
    Sums s;
    memcpy(&s, word, sizeof(Sums));
    return s;
  }
  /// By every thread.
  __device__ void add(const Sums& own) const {
    __shared__ bool last;
    const Sums mine = over_block(sum_of_warp(own));
    if (threadIdx.x == 0) {
      part[first + blockIdx.x] = mine;
      __threadfence();
      last = atomicAdd(finished, 1u) == blocks - 1;
    }
    __syncthreads();
    if (!last) return;
    __threadfence();
    Sums all{};
    for (unsigned b = threadIdx.x; b < blocks; b += threads) all += seen(b);
    all = over_block(sum_of_warp(all));
    if (threadIdx.x != 0) return;
    *total = all;
    *finished = 0;
  }
};

}  // namespace drench::kokkos_backend
