// The cloth's Jacobi iterations in one kernel that stays on the device (cloth_solver.hpp). Two lanes share a node, each with
// half of its links in registers: of an iteration only the shifts of the other nodes come from elsewhere, those of the
// block's own patch from shared memory, those around it from the second-level cache (the first one is not coherent).
// A shift says itself of which iterate it is, in the same 16 bytes, so that a block waits for what it reads and for nothing
// else (as NCCL's LL protocol does). Where 16 bytes are not loaded at once (double, compute capability below 7), with strain
// limits, or where patches have too much around them, there is a barrier for the whole grid between two iterations instead.

#include <cooperative_groups.h>

#include <algorithm>
#include <cstdint>
#include <memory>
#include <stdexcept>
#include <string>
#include <utility>

#include "cloth_patches.hpp"
#include "cloth_solver.hpp"

namespace drench::kokkos_backend {
namespace {

namespace groups = cooperative_groups;

constexpr int warp = 32, most_threads = 512, fewer_threads = 384, lanes = 2;
constexpr unsigned all_lanes = 0xffffffff;
// Loads of 128 bits that nothing can come between: PTX ISA 8.3.
#if !defined(DRENCH_DOUBLE) && CUDART_VERSION >= 12030 && !defined(KOKKOS_ARCH_PASCAL)
#define DRENCH_DATED_SHIFTS
constexpr bool dated_shifts = true;
#else
constexpr bool dated_shifts = false;
#endif
constexpr int most_around = 1024;  // nodes that a patch may have around it

struct ResidentArrays {
  Real3 *shift, *last_shift;
  Real4* iterate[2];
  TwoSums* part;  // of each block
  const double* spectral_bound;
  ClothProgress *progress, *seen;
};

struct ResidentRun {
  ClothProgress begin;
  bool first;  // of the solve
  int most;
  double tolerance, floor;
};

/// An array of shifts, read past the first-level cache.
struct Iterate {
  const Real4* data;
  __device__ Real3 operator()(Index n) const {
#ifdef DRENCH_DOUBLE
    const double2 v = __ldcg(reinterpret_cast<const double2*>(data + n));
    return {v.x, v.y, __ldcg(&data[n].z)};
#else
    const float4 v = __ldcg(reinterpret_cast<const float4*>(data + n));
    return {v.x, v.y, v.z};
#endif
  }
};

#ifdef DRENCH_DATED_SHIFTS
/// A shift and its date, in one piece.
__device__ void store_dated(Real4* to, const Real3& shift, int date) {
  const std::uint64_t xy = std::uint64_t(__float_as_uint(shift.y)) << 32 | __float_as_uint(shift.x);
  const std::uint64_t zw = std::uint64_t(static_cast<unsigned>(date)) << 32 | __float_as_uint(shift.z);
  asm volatile("{ .reg .b128 both; mov.b128 both, {%1, %2}; st.relaxed.gpu.global.b128 [%0], both; }" ::"l"(to),
               "l"(xy), "l"(zw)
               : "memory");
}
/// Waits for the shift of that date.
__device__ Real3 load_dated(const Real4* from, int date) {
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
__device__ void store_dated(Real4*, const Real3&, int) {}
__device__ Real3 load_dated(const Real4*, int) { return {}; }
#endif

__device__ TwoSums sum_of_warp(TwoSums s) {
  for (int apart = warp / 2; apart > 0; apart /= 2) {
    s.first += __shfl_down_sync(all_lanes, s.first, apart);
    s.second += __shfl_down_sync(all_lanes, s.second, apart);
  }
  return s;
}

/// The sum over the grid, the same in all threads; always in the same order.
__device__ TwoSums sum_of_grid(const groups::grid_group& grid, TwoSums s, TwoSums* part) {
  __shared__ TwoSums room[most_threads / warp];
  __shared__ TwoSums total;
  s = sum_of_warp(s);
  if (threadIdx.x % warp == 0) room[threadIdx.x / warp] = s;
  __syncthreads();
  if (threadIdx.x == 0) {
    for (unsigned w = 1; w < blockDim.x / warp; ++w) s += room[w];
    part[blockIdx.x] = s;
  }
  grid.sync();
  if (threadIdx.x < warp) {
    TwoSums all;
    for (unsigned b = threadIdx.x; b < gridDim.x; b += warp) all += {__ldcg(&part[b].first), __ldcg(&part[b].second)};
    all = sum_of_warp(all);
    if (threadIdx.x == 0) total = all;
  }
  __syncthreads();
  return total;
}

/// A link with all that stays the same: x⁰_n − x⁰_m (m) and its strain damping (laws/elasticity.hpp).
struct NearLink {
  Link link{};
  Real3 apart;
  Real damping = 0;
};

/// `kept`: the most links of a lane. `plain`: without solids and strain limits, whose registers the links then have.
/// `threads`: of a block at most; the fewer, the more registers a lane has. `dated`: without barriers, in patches.
template <int kept, bool plain, int threads, bool dated>
__global__ void __launch_bounds__(threads)
    iterate(ClothSystem s, ResidentArrays a, PatchView patch, ResidentRun run, Index nodes) {
  const groups::grid_group grid = groups::this_grid();
  const int thread = static_cast<int>(blockIdx.x * blockDim.x + threadIdx.x), lane = thread % lanes;
  const Index place = thread / lanes, n = dated && place < nodes ? patch.order[place] : place;
  extern __shared__ Real4 patch_shift[];  // two iterates of `room` shifts
  const int own = static_cast<int>(threadIdx.x) / lanes, own_nodes = static_cast<int>(blockDim.x) / lanes;
  const Index around_first = dated ? patch.around_start[blockIdx.x] : 0;
  const int around_count = dated ? patch.around_start[blockIdx.x + 1] - around_first : 0;
  const bool free = n < nodes && !s.pinned(n);
  ClothProgress progress = run.first ? run.begin : *a.progress;
  if (run.first) progress.rho = Kokkos::fmin(progress.rho, *a.spectral_bound);
  NodeTerms terms{};
  Real3 moved, before;
  // What a lane has no link for leads to the node itself with a force of 0: without branches between them all loads of an
  // iteration are under way at once.
  NearLink link[kept];  // `other`: a node, or its place in the patch
#pragma unroll
  for (int k = 0; k < kept; ++k) link[k].link.other = dated ? own : n < nodes ? n : 0;
  if (n < nodes) {
    moved = a.shift[n];
    before = a.last_shift[n];
    if (lane == 0) {
      if constexpr (dated) {
        store_dated(a.iterate[0] + n, moved, 1);
        store_dated(a.iterate[1] + n, moved, 0);
      } else {
        a.iterate[0][n] = a.iterate[1][n] = Real4(moved, 0);
      }
    }
  }
  if (dated && lane == 0) patch_shift[own] = patch_shift[patch.room + own] = Real4(moved, 0);
  if (free) {
    terms = s.terms(n);
    const Real rate = s.strain_damping_rate(n);
    const Index first = s.link_start(n) + lane, last = s.link_start(n + 1);
#pragma unroll
    for (int k = 0; k < kept; ++k)
      if (first + lanes * k < last) {
        const Link l = s.link(first + lanes * k);
        const Real3 apart = terms.start - s.start(l.other);
        link[k] = {l, apart, rate > 0 ? strain_damping(apart, l.stiffness, rate) : Real(0)};
        if constexpr (dated) link[k].link.other = patch.local[first + lanes * k];
      }
  }
  grid.sync();
  int current = 0, date = 1;  // of the iterate that is there
  Real3 other[kept];
  const int first_around = static_cast<int>(threadIdx.x);
  const Index node_around = first_around < around_count ? patch.around[around_first + first_around] : 0;
  const auto load = [&] {
    if constexpr (dated) {
      // What a block overwrites here it has read two iterations ago, before the barrier of the one between.
      Real4* const room = patch_shift + current * patch.room;
      for (int k = first_around; k < around_count; k += static_cast<int>(blockDim.x)) {
        const Index node = k == first_around ? node_around : patch.around[around_first + k];
        room[own_nodes + k] = Real4(load_dated(a.iterate[current] + node, date), 0);
      }
      __syncthreads();
#pragma unroll
      for (int k = 0; k < kept; ++k) other[k] = room[link[k].link.other].xyz();
    } else {
      const Iterate shift{a.iterate[current]};
#pragma unroll
      for (int k = 0; k < kept; ++k) other[k] = shift(link[k].link.other);
    }
  };
  // r_n, the same on both lanes.
  const auto residual = [&] {
    Real3 force;
#pragma unroll
    for (int k = 0; k < kept; ++k)
      ClothSystem::add_link(force, link[k].link, link[k].apart, moved - other[k], link[k].damping);
    if constexpr (!plain)
      if (free && s.limit_start.exist()) force += s.limit_force(n, Iterate{a.iterate[current]}, lane, lanes);
    force += Real3{__shfl_xor_sync(all_lanes, force.x, 1), __shfl_xor_sync(all_lanes, force.y, 1),
                   __shfl_xor_sync(all_lanes, force.z, 1)};
    return terms.inertia * (terms.target - moved) + force;
  };
  const auto step = [&](const Real3& r, Real omega) {
    const Real3 next = free ? s.next_shift<!plain>(terms, moved, before, r, omega) : moved;
    if constexpr (dated) {
      // Pinned nodes, too, have a new date.
      if (lane == 0 && n < nodes) {
        store_dated(a.iterate[current ^ 1] + n, next, date + 1);
        patch_shift[(current ^ 1) * patch.room + own] = Real4(next, 0);
      }
    } else if (free && lane == 0) {
      a.iterate[current ^ 1][n] = Real4(next, 0);
    }
    return next;
  };
  const int end = progress.iterations + run.most;
  const auto next_check = [&] {
    return progress.iterations + check_interval < end ? progress.iterations + check_interval : end;
  };
  ClothProgress ahead = progress;  // with the next iterate
  Real omega = ahead.next_weight();
  for (int check = next_check();;) {
    load();
    const Real3 r = residual();
    Real3 next = step(r, omega);
    if (progress.iterations == check) {
      // The next iterate is on its way already: one barrier serves it and the sum.
      const TwoSums own =
          free && lane == 0 ? s.imbalance<!plain>(terms, moved, r, run.tolerance, run.floor) : TwoSums{};
      progress.judge(over_goal(sum_of_grid(grid, own, a.part)));
      if (progress.residual <= 1 || progress.iterations >= end) break;
      check = next_check();
      const bool restarts = progress.since_restart == 0;
      ahead = progress;
      omega = ahead.next_weight();
      if (restarts) {
        next = step(r, omega);
        grid.sync();
      }
      progress = ahead;
      omega = ahead.next_weight();
    } else if (dated) {
      progress = ahead;
      omega = ahead.next_weight();
    } else {
#if CUDART_VERSION >= 12020
      auto arrived = grid.barrier_arrive();
#else
      grid.sync();
#endif
      progress = ahead;
      omega = ahead.next_weight();  // a division in double, while the others arrive
#if CUDART_VERSION >= 12020
      grid.barrier_wait(std::move(arrived));
#endif
    }
    before = moved;
    moved = next;
    current ^= 1;
    ++date;
  }
  if (free && lane == 0) {
    a.shift[n] = moved;
    a.last_shift[n] = before;
  }
  if (thread == 0) *a.progress = *a.seen = progress;
}

void check(cudaError_t status) {
  if (status != cudaSuccess) throw std::runtime_error(std::string("cloth: ") + cudaGetErrorString(status));
}

/// How the kernel is launched for a cloth, kept from solve to solve.
struct Plan {
  const void* kernel = nullptr;  // null: the cloth does not fit
  int threads = 0, blocks = 0, shared_bytes = 0;
};

/// The kernel for nodes with `links` a lane at most in blocks of `block` threads, or null.
template <bool plain, int threads, bool dated>
const void* kernel_with(int links) {
  return links <= 6    ? reinterpret_cast<const void*>(&iterate<6, plain, threads, dated>)
         : links <= 9  ? reinterpret_cast<const void*>(&iterate<9, plain, threads, dated>)
         : links <= 14 ? reinterpret_cast<const void*>(&iterate<14, plain, threads, dated>)
                       : nullptr;
}
template <bool dated>
const void* kernel_for(int links, bool plain, int block) {
  if (block <= fewer_threads)
    return plain ? kernel_with<true, fewer_threads, dated>(links) : kernel_with<false, fewer_threads, dated>(links);
  return plain ? kernel_with<true, most_threads, dated>(links) : kernel_with<false, most_threads, dated>(links);
}

/// Blocks of as few threads as spread the nodes over all processors; a node with `rows` links at most.
template <bool dated>
Plan make_plan(Index nodes, int rows, bool plain, int room) {
  const cudaDeviceProp& device = ExecSpace().cuda_device_prop();
  const int processors = device.multiProcessorCount, each = (rows + lanes - 1) / lanes;
  if (!device.cooperativeLaunch) return {};
  for (int blocks_each = 1; blocks_each <= 8; ++blocks_each) {
    const int share = (lanes * nodes + processors * blocks_each - 1) / (processors * blocks_each);
    const int threads = std::clamp((share + warp - 1) / warp * warp, 2 * warp, most_threads);
    const int blocks = (lanes * nodes + threads - 1) / threads;
    const void* const kernel = kernel_for<dated>(each, plain, threads);
    if (kernel == nullptr) return {};
    const int shared_bytes = dated ? 2 * (threads / lanes + room) * static_cast<int>(sizeof(Real4)) : 0;
    int at_once = 0;  // a processor
    check(cudaOccupancyMaxActiveBlocksPerMultiprocessor(&at_once, kernel, threads, shared_bytes));
    if (at_once * processors >= blocks) return {kernel, threads, blocks, shared_bytes};
  }
  return {};
}

}  // namespace

struct ResidentCloth {
  Plan plan;
  Patches patches;
  Array<Real4> iterate[2];
  Array<TwoSums> part;
  Kokkos::View<double, MemSpace> spectral_bound;
  Kokkos::View<ClothProgress, MemSpace> progress;
  Kokkos::View<ClothProgress, Kokkos::SharedHostPinnedSpace> seen;
};

bool prepare_resident_cloth(Device& d, const ClothSystem& s) {
  std::shared_ptr<ResidentCloth>& r = d.cloth_work.resident;
  if (r == nullptr) {
    r = std::make_shared<ResidentCloth>();
    const auto nodes = static_cast<std::size_t>(d.nodes.count);
    const int rows = static_cast<int>(maximum(
        "drench::cloth::most_links", d.nodes.count,
        KOKKOS_LAMBDA(const Index n) { return static_cast<double>(s.link_start(n + 1) - s.link_start(n)); }));
    const bool limits = s.limit_start.exist(), plain = s.solids.count == 0 && !limits;
    r->plan = make_plan<false>(d.nodes.count, rows, plain, 0);
    if (dated_shifts && !limits && r->plan.kernel != nullptr) {
      // With room for the most that may lie around a patch, for that is known only once the patches are.
      const Plan dated = make_plan<true>(d.nodes.count, rows, plain, most_around);
      if (dated.kernel != nullptr) {
        Patches patches = make_patches(d, dated.threads / lanes);
        if (patches.most <= most_around) {
          r->plan = dated;
          r->plan.shared_bytes = 2 * (dated.threads / lanes + patches.most) * static_cast<int>(sizeof(Real4));
          r->patches = std::move(patches);
        }
      }
    }
    if (r->plan.kernel == nullptr) return false;
    for (Array<Real4>& i : r->iterate) i = Array<Real4>("drench::cloth::iterate", nodes);
    r->part = Array<TwoSums>("drench::cloth::part", static_cast<std::size_t>(r->plan.blocks));
    r->spectral_bound = Kokkos::View<double, MemSpace>("drench::cloth::spectral_bound");
    r->progress = Kokkos::View<ClothProgress, MemSpace>("drench::cloth::progress");
    r->seen = Kokkos::View<ClothProgress, Kokkos::SharedHostPinnedSpace>("drench::cloth::progress_seen");
  }
  return r->plan.kernel != nullptr;
}

Kokkos::View<double, MemSpace> resident_spectral_bound(const Device& d) {
  return d.cloth_work.resident->spectral_bound;
}

void run_resident_cloth(Device& d, const ClothSystem& s, const ClothProgress* begin, int most, double tolerance,
                        double floor) {
  ResidentCloth& r = *d.cloth_work.resident;
  ClothSystem system = s;
  ResidentArrays arrays{d.cloth_work.shift.data(),
                        d.cloth_work.last_shift.data(),
                        {r.iterate[0].data(), r.iterate[1].data()},
                        r.part.data(),
                        r.spectral_bound.data(),
                        r.progress.data(),
                        r.seen.data()};
  ResidentRun run{begin != nullptr ? *begin : ClothProgress{}, begin != nullptr, most, tolerance, floor};
  PatchView patch = r.patches.view(r.plan.threads / lanes);
  Index nodes = d.nodes.count;
  void* arguments[] = {&system, &arrays, &patch, &run, &nodes};
  const ExecSpace space;
  std::uint64_t id = 0;
  Kokkos::Tools::beginParallelFor("drench::cloth::resident", Kokkos::Tools::Experimental::device_id(space), &id);
  check(cudaLaunchCooperativeKernel(r.plan.kernel, dim3(static_cast<unsigned>(r.plan.blocks)),
                                    dim3(static_cast<unsigned>(r.plan.threads)), arguments,
                                    static_cast<std::size_t>(r.plan.shared_bytes), space.cuda_stream()));
  Kokkos::Tools::endParallelFor(id);
}

ClothProgress resident_progress(const Device& d) {
  ExecSpace().fence("drench::cloth::resident");
  return d.cloth_work.resident->seen();
}

}  // namespace drench::kokkos_backend
