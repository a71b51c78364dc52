#pragma once
// How the blocks of the resident cloth kernel exchange shifts and sums.

#include <cooperative_groups.h>

#include <cstdint>
#include <utility>

#include "core/reduce.hpp"

namespace drench::kokkos_backend::resident {

namespace groups = cooperative_groups;

inline constexpr int warp = warp_size, most_threads = 512, fewer_threads = 384;
static_assert(most_threads % warp == 0 && fewer_threads % warp == 0, "sums run over whole warps");
inline constexpr unsigned all_lanes = 0xffffffff;
// A shift says itself of which iterate it is, in the same 16 bytes (as in NCCL's LL protocol): a block waits for those
// that it reads, not for the grid. That takes loads of 128 bits that nothing can come between: PTX ISA 8.3, compute
// capability 7. In double, with strain limits, with membranes or with too many nodes around a patch the grid has a
// barrier an iteration instead. A program for several capabilities compiles both kernels for each of them, with an
// empty body for older ones; compiled_for() reports to the host which it can use.
#if !defined(DRENCH_DOUBLE) && CUDART_VERSION >= 12030 && DRENCH_CUDA_NEWEST >= 70
#define DRENCH_DATED_SHIFTS
inline constexpr bool dated_shifts = true;
#else
inline constexpr bool dated_shifts = false;
#endif
// One cluster of blocks reads each other's shared memory: compute capability 9.
#if CUDART_VERSION >= 12000 && DRENCH_CUDA_NEWEST >= 90
#define DRENCH_CLUSTERS
#if !defined(__CUDA_ARCH__) || __CUDA_ARCH__ >= 900
#define DRENCH_CLUSTERS_HERE
#endif
#endif
inline constexpr int needed_for_dates = 70, needed_for_clusters = 90;
inline constexpr int most_in_cluster = 16;  // blocks; more than 8 must be asked for
/// How nodes see the shifts of others: in global memory, with a barrier of the grid an iteration; in patches, by dates;
/// in the shared memory of one cluster of blocks.
enum class Exchange { barrier, dated, cluster };
/// Is it in the code that this pass of nvcc compiles? The pass for the host launches what compiled_for() allows.
template <Exchange exchange>
inline constexpr bool compiled_here = true;
#ifdef __CUDA_ARCH__
template <>
inline constexpr bool compiled_here<Exchange::dated> = dated_shifts&& __CUDA_ARCH__ >= 10 * needed_for_dates;
template <>
inline constexpr bool compiled_here<Exchange::cluster> = __CUDA_ARCH__ >= 10 * needed_for_clusters;
#endif
static_assert(!dated_shifts || (sizeof(Real4) == 16 && alignof(Real4) == 16), "a shift and its date are 128 bits");

#if defined(DRENCH_DATED_SHIFTS) && (!defined(__CUDA_ARCH__) || __CUDA_ARCH__ >= 700)
/// A shift and its date, in one piece.
inline __device__ void store_dated(Real4* to, const Real3& shift, int date) {
  const std::uint64_t xy = std::uint64_t(__float_as_uint(shift.y)) << 32 | __float_as_uint(shift.x);
  const std::uint64_t zw = std::uint64_t(static_cast<unsigned>(date)) << 32 | __float_as_uint(shift.z);
  asm volatile("{ .reg .b128 both; mov.b128 both, {%1, %2}; st.relaxed.gpu.global.b128 [%0], both; }" ::"l"(to),
               "l"(xy), "l"(zw)
               : "memory");
}
/// Waits for the shift of that date.
inline __device__ Real3 load_dated(const Real4* from, int date) {
  std::uint64_t xy, zw;
  do {
    asm volatile("{ .reg .b128 both; ld.relaxed.gpu.global.b128 both, [%2]; mov.b128 {%0, %1}, both; }"
                 : "=l"(xy), "=l"(zw)
                 : "l"(from)
                 : "memory");
  } while (static_cast<int>(zw >> 32) != date);
  return {__uint_as_float(static_cast<unsigned>(xy)), __uint_as_float(static_cast<unsigned>(xy >> 32)),
          __uint_as_float(static_cast<unsigned>(zw))};
}
#else
inline __device__ void store_dated(Real4*, const Real3&, int) {}
inline __device__ Real3 load_dated(const Real4*, int) { return {}; }
#endif

inline __device__ TwoSums sum_of_warp(TwoSums s) {
  for (int apart = warp / 2; apart > 0; apart /= 2) {
    s.first += __shfl_down_sync(all_lanes, s.first, apart);
    s.second += __shfl_down_sync(all_lanes, s.second, apart);
  }
  return s;
}

/// The sum over a block, in its first thread; always in the same order.
inline __device__ TwoSums sum_of_block(TwoSums s) {
  __shared__ TwoSums room[most_threads / warp];
  s = sum_of_warp(s);
  if (threadIdx.x % warp == 0) room[threadIdx.x / warp] = s;
  __syncthreads();
  if (threadIdx.x == 0)
    for (unsigned w = 1; w < blockDim.x / warp; ++w) s += room[w];
  return s;
}

/// All blocks, which meet at barriers.
template <Exchange exchange>
struct Meeting {
  groups::grid_group all = groups::this_grid();

  __device__ void sync() { all.sync(); }
  /// Does `work` while the others arrive.
  template <class Work>
  __device__ void sync_beside(const Work& work) {
#if CUDART_VERSION >= 12020
    auto arrived = all.barrier_arrive();
    work();
    all.barrier_wait(std::move(arrived));
#else
    all.sync();
    work();
#endif
  }
  /// The sum over all blocks, the same in all threads; always in the same order.
  __device__ TwoSums sum(TwoSums s, TwoSums* part) {
    __shared__ TwoSums total;
    s = sum_of_block(s);
    if (threadIdx.x == 0) part[blockIdx.x] = s;
    all.sync();
    if (threadIdx.x < warp) {
      TwoSums every;
      for (unsigned b = threadIdx.x; b < gridDim.x; b += warp)
        every += {__ldcg(&part[b].first), __ldcg(&part[b].second)};
      every = sum_of_warp(every);
      if (threadIdx.x == 0) total = every;
    }
    __syncthreads();
    return total;
  }
};

#ifdef DRENCH_CLUSTERS_HERE
template <>
struct Meeting<Exchange::cluster> {
  groups::cluster_group all = groups::this_cluster();
  int turn = 0;

  __device__ void sync() { all.sync(); }
  template <class Work>
  __device__ void sync_beside(const Work& work) {
    auto arrived = all.barrier_arrive();
    work();
    all.barrier_wait(std::move(arrived));
  }
  /// Each block gets the parts of all. Two sums may follow each other with one barrier between: they have room each.
  __device__ TwoSums sum(TwoSums s, TwoSums*) {
    __shared__ TwoSums part[2][most_in_cluster];
    turn ^= 1;
    s = sum_of_block(s);
    if (threadIdx.x == 0)
      for (unsigned b = 0; b < gridDim.x; ++b) *all.map_shared_rank(&part[turn][blockIdx.x], b) = s;
    all.sync();
    TwoSums total = part[turn][0];
    for (unsigned b = 1; b < gridDim.x; ++b) total += part[turn][b];
    return total;
  }
};
#endif

}  // namespace drench::kokkos_backend::resident
