#pragma once
// The cloth's Jacobi iterations in one kernel that stays on the device (cloth/solver.hpp): launches would take longer.
// Some lanes share a node, each with a part of its links in registers and a part of its triangles. Of the shifts that
// an iteration reads, those of the block's own patch lie in shared memory, those around it in the second-level cache
// (the first one is not coherent).

#include "cloth/cuda/block_exchange.hpp"
#include "cloth/cuda/patches.hpp"
#include "cloth/solver.hpp"

namespace drench::kokkos_backend::resident {

/// Lanes of a node whose triangles matter, from the first that fits: a triangle is a long chain of loads and roots.
inline constexpr int lanes_of_links = 2, lanes_of_triangles[] = {8, 4, 2};
inline constexpr int most_around = 1024;  // nodes that a patch may have around it
static_assert(most_threads / lanes_of_links + most_around <= 1 << 16, "PatchView::local has 16 bits");

/// What the kernel reads and writes beside a ClothSystem.
struct ResidentArrays {
  Real3 *shift, *last_shift;
  Real4* iterate[2];
  TwoSums* part;  // of each block
  const double* spectral_bound;
  ClothProgress *progress, *seen;
};

/// One call.
struct ResidentRun {
  ClothProgress begin;
  bool first;         // of the solve
  bool after_newton;  // nothing is left to do if Newton's method has converged
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

/// A link with all that stays the same: x⁰_n − x⁰_m (m) and its strain damping (cloth/elasticity.hpp).
struct NearLink {
  Link link{};
  Real3 apart;
  Real excess = 0, damping = 0;
};

/// A triangle of a node with all that stays the same.
struct NearTriangle {
  TriangleTerms<Real> terms;
  Index other[2];   // its next corners after the node, in their cyclic order
  int corner = -1;  // which of its corners the node is; −1: there is no triangle
};

/// A lane's part of a node: what it keeps in registers, and the iterate that is there.
/// `kept`: the most links of a lane; `triangles`: of its triangles, likewise, or 0: they are read at each iteration.
/// `plain`: without solids, strain limits and membranes, whose registers the links then have.
template <int kept, bool plain, Exchange exchange, int lanes, int triangles>
struct NodeIterates {
  static_assert(warp % lanes == 0 && (lanes & (lanes - 1)) == 0, "residual() adds the lanes by halves");
  static constexpr bool dated = exchange == Exchange::dated, clustered = exchange == Exchange::cluster,
                        in_patches = dated || clustered;

  const ClothSystem& s;
  const ResidentArrays& a;
  const PatchView& patch;
  const Index nodes;
  const int thread, lane;
  const Index n;
  const int own, own_nodes;  // place in the patch, of how many
  const Index around_first;
  const int around_count, first_around;
  const Index node_around;
  const bool free;
  NodeTerms terms{};
  Real3 moved, before;  // u_n of this iterate and of the last one, m
  NearLink link[kept];  // `other`: a node, or its place in the patch
  Real3 other[kept];    // u of the links' other nodes, m
  NearTriangle near[triangles > 0 ? triangles : 1];
  Real3 corners[triangles > 0 ? 2 * triangles : 1];  // u of the triangles' other corners, m
  const Real4* seen[clustered ? kept : 1];           // where they are in the first of two iterates
  int current = 0, date = 1;                         // of the iterate that is there

  __device__ NodeIterates(const ClothSystem& system, const ResidentArrays& arrays, const PatchView& view, Index count)
      : s(system),
        a(arrays),
        patch(view),
        nodes(count),
        thread(static_cast<int>(blockIdx.x * blockDim.x + threadIdx.x)),
        lane(thread % lanes),
        n(in_patches && thread / lanes < nodes ? patch.order[thread / lanes] : thread / lanes),
        own(static_cast<int>(threadIdx.x) / lanes),
        own_nodes(static_cast<int>(blockDim.x) / lanes),
        around_first(dated ? patch.around_start[blockIdx.x] : 0),
        around_count(dated ? patch.around_start[blockIdx.x + 1] - around_first : 0),
        first_around(static_cast<int>(threadIdx.x)),
        node_around(first_around < around_count ? patch.around[around_first + first_around] : 0),
        free(n < nodes && !s.pinned(n)) {}

  /// The patch's shifts of an even or an odd iterate, in shared memory.
  __device__ Real4* patch_shifts(int which) const {
    extern __shared__ Real4 patch_shift[];  // two iterates of `room` shifts
    return patch_shift + which * patch.room;
  }

  /// Puts the first iterate where the others read it; the grid waits for that.
  __device__ void begin() {
    if (n < nodes) {
      moved = a.shift[n];
      before = a.last_shift[n];
      if (lane == 0 && !clustered) {
        if constexpr (dated) {
          store_dated(a.iterate[0] + n, moved, 1);
          store_dated(a.iterate[1] + n, moved, 0);
        } else {
          a.iterate[0][n] = a.iterate[1][n] = Real4(moved, 0);
        }
      }
    }
    if (in_patches && lane == 0) patch_shifts(0)[own] = patch_shifts(1)[own] = Real4(moved, 0);
    keep_links();
  }
  /// A link that a lane lacks leads to the node itself with a force of 0: without branches between them all loads of an
  /// iteration are under way at once.
  __device__ void keep_links() {
#pragma unroll
    for (int k = 0; k < kept; ++k) set_other(k, dated ? own : clustered ? thread / lanes : n < nodes ? n : 0);
    for (NearTriangle& t : near) t.other[0] = t.other[1] = n < nodes ? n : 0;
    if (!free) return;
    terms = s.terms(n);
    const Real rate = s.strain_damping_rate(n);
    const Index first = s.link_start(n) + lane, last = s.link_start(n + 1);
#pragma unroll
    for (int k = 0; k < kept; ++k)
      if (first + lanes * k < last) {
        const Link l = s.link(first + lanes * k);
        const Real3 apart = terms.start - s.start(l.other);
        link[k] = {l, apart, l.stiffness > 0 ? spring_excess<Real>(terms.start, s.start(l.other), l.length) : Real(0),
                   rate > 0 ? strain_damping(apart, l.stiffness, rate) : Real(0)};
        if constexpr (in_patches) set_other(k, patch.local[first + lanes * k]);
      }
    if constexpr (triangles > 0) {
      const Index begin = s.triangle_start(n) + lane, end = s.triangle_start(n + 1);
#pragma unroll
      for (int k = 0; k < triangles; ++k) {
        if (begin + lanes * k >= end) continue;
        const Index t = s.triangle_item(begin + lanes * k) / 4;
        near[k].corner = s.triangle_item(begin + lanes * k) % 4;
        near[k].terms = s.template triangle_terms<Real>(t);
        for (int c = 0; c < 2; ++c) near[k].other[c] = s.triangle(3 * t + (near[k].corner + 1 + c) % 3);
      }
    }
  }
  /// `place`: of a node, in the patch, or in the order of all patches.
  __device__ void set_other(int k, Index place) {
    link[k].link.other = place;
#ifdef DRENCH_CLUSTERS_HERE
    if constexpr (clustered)
      seen[k] = groups::this_cluster().map_shared_rank(patch_shifts(0) + place % own_nodes,
                                                       static_cast<unsigned>(place / own_nodes));
#endif
  }

  /// The shifts of the links' other nodes.
  __device__ void load() {
    if constexpr (dated) {
      // Double buffering: this slot was last read two iterations ago; the __syncthreads of the previous iteration
      // orders that read before this write.
      Real4* const room = patch_shifts(current);
      for (int k = first_around; k < around_count; k += static_cast<int>(blockDim.x)) {
        const Index node = k == first_around ? node_around : patch.around[around_first + k];
        room[own_nodes + k] = Real4(load_dated(a.iterate[current] + node, date), 0);
      }
      __syncthreads();
#pragma unroll
      for (int k = 0; k < kept; ++k) other[k] = room[link[k].link.other].xyz();
    } else if constexpr (clustered) {
      const int which = current * patch.room;
#pragma unroll
      for (int k = 0; k < kept; ++k) other[k] = seen[k][which].xyz();
    } else {
      const Iterate shift{a.iterate[current]};
#pragma unroll
      for (int k = 0; k < kept; ++k) other[k] = shift(link[k].link.other);
      if constexpr (triangles > 0) {
#pragma unroll
        for (int k = 0; k < 2 * triangles; ++k) corners[k] = shift(near[k / 2].other[k % 2]);
      }
    }
  }
  /// What triangle k of the lane does to its node, N.
  __device__ Real3 triangle_force(int k) const {
    const int c = near[k].corner;
    const Real3 &next = corners[2 * k], &last = corners[2 * k + 1];
    const Real3 a = c == 0   ? moved
                    : c == 1 ? last
                             : next,
                b = c == 1   ? moved
                    : c == 0 ? next
                             : last,
                d = c == 2   ? moved
                    : c == 0 ? last
                             : next;
    return corner_force(s.triangle_stress(near[k].terms, a, b, d), corner_gradient(near[k].terms.shape, c));
  }
  /// r_n, N, the same on all of its lanes.
  __device__ Real3 residual() const {
    Real3 force;
#pragma unroll
    for (int k = 0; k < kept; ++k)
      ClothSystem::add_link(force, link[k].link, link[k].apart, moved - other[k], link[k].excess, link[k].damping);
    if constexpr (triangles > 0) {
#pragma unroll
      for (int k = 0; k < triangles; ++k)
        if (near[k].corner >= 0) force += triangle_force(k);
    } else if constexpr (!plain)
      if (free && s.triangle_start.exist()) force += s.triangle_force(n, Iterate{a.iterate[current]}, lane, lanes);
#pragma unroll
    for (int apart = 1; apart < lanes; apart *= 2)
      force += Real3{__shfl_xor_sync(all_lanes, force.x, apart), __shfl_xor_sync(all_lanes, force.y, apart),
                     __shfl_xor_sync(all_lanes, force.z, apart)};
    return terms.inertia * (terms.target - moved) + force;
  }
  /// The next iterate, put where the others read it.
  __device__ Real3 step(const Real3& r, Real omega) const {
    const Real3 next = free ? s.next_shift<!plain>(terms, moved, before, r, omega) : moved;
    if constexpr (dated) {
      // Pinned nodes, too, have a new date.
      if (lane == 0 && n < nodes) {
        store_dated(a.iterate[current ^ 1] + n, next, date + 1);
        patch_shifts(current ^ 1)[own] = Real4(next, 0);
      }
    } else if constexpr (clustered) {
      if (lane == 0) patch_shifts(current ^ 1)[own] = Real4(next, 0);
    } else if (free && lane == 0) {
      a.iterate[current ^ 1][n] = Real4(next, 0);
    }
    return next;
  }
  /// The node's share of the check.
  __device__ TwoSums imbalance(const Real3& r, const ResidentRun& run) const {
    return free && lane == 0 ? s.imbalance<!plain>(terms, moved, r, run.tolerance, run.floor) : TwoSums{};
  }
  __device__ void advance(const Real3& next) {
    before = moved;
    moved = next;
    current ^= 1;
    ++date;
  }
  __device__ void end() const {
    if (!free || lane != 0) return;
    a.shift[n] = moved;
    a.last_shift[n] = before;
  }
};

/// Chebyshev's weights where a call begins.
inline __device__ ClothProgress progress_at_start(const ClothSystem& s, const ResidentArrays& a,
                                                  const ResidentRun& run) {
  ClothProgress progress = run.first ? run.begin : *a.progress;
  if (run.first)
    progress.rho = smaller(progress.rho, *a.spectral_bound);
  else if (progress.iterations > 0)  // 0: Newton's method has left all of it
    progress.move_on(s.solids.extent(0) > 0);
  return progress;
}

/// Copies the first solids to shared memory: every iteration of a node asks for them.
inline constexpr int most_shared_solids = 8;
__device__ __forceinline__ Slice<const Solid> in_shared_memory(const Slice<const Solid>& solids) {
  static_assert(sizeof(Solid) % sizeof(unsigned) == 0);
  __shared__ alignas(Solid) unsigned room[most_shared_solids * sizeof(Solid) / sizeof(unsigned)];
  if (solids.count > most_shared_solids) return solids;
  const auto* const from = reinterpret_cast<const unsigned*>(solids.data);
  const auto words = static_cast<unsigned>(static_cast<std::size_t>(solids.count) * sizeof(Solid) / sizeof(unsigned));
  for (unsigned k = threadIdx.x; k < words; k += blockDim.x) room[k] = from[k];
  __syncthreads();
  return {reinterpret_cast<const Solid*>(room), static_cast<std::size_t>(solids.count)};
}

/// `threads`: of a block at most; the fewer, the more registers a lane has.
template <int kept, bool plain, int threads, Exchange exchange, int lanes, int triangles>
__global__ void __launch_bounds__(threads, 1)
    iterate(ClothSystem s, ResidentArrays a, PatchView patch, ResidentRun run, Index nodes) {
  if constexpr (compiled_here<exchange>) {
    if (run.after_newton && a.progress->residual <= 1) return;
    if constexpr (!plain) s.solids = in_shared_memory(s.solids);
    Meeting<exchange> meeting;
    NodeIterates<kept, plain, exchange, lanes, triangles> node(s, a, patch, nodes);
    ClothProgress progress = progress_at_start(s, a, run);
    node.begin();
    meeting.sync();
    const int end = progress.iterations + run.most;
    const auto next_check = [&] {
      return progress.iterations + check_interval < end ? progress.iterations + check_interval : end;
    };
    ClothProgress ahead = progress;  // with the next iterate
    Real omega = ahead.next_weight();
    const auto go_ahead = [&] {
      progress = ahead;
      omega = ahead.next_weight();  // a division in double
    };
    for (int check = next_check();;) {
      node.load();
      const Real3 r = node.residual();
      bool found = false, done = false;  // at a check: the sum; the solve
      Real3 next;
      // A second time where the check restarts the weights. The code of a step is long and is there once.
#pragma unroll 1
      for (bool again = true; again;) {
        next = node.step(r, omega);
        again = false;
        if (found) {
          meeting.sync();
          go_ahead();
        } else if (progress.iterations == check) {
          // The next iterate is on its way already: one barrier serves it and the sum.
          progress.judge(over_goal(meeting.sum(node.imbalance(r, run), a.part)));
          found = true;
          done = progress.residual <= 1 || progress.iterations >= end || progress.stalls();
          if (done) break;
          check = next_check();
          again = progress.since_restart == 0;
          ahead = progress;
          omega = ahead.next_weight();
          if (!again) go_ahead();
        } else if constexpr (exchange == Exchange::dated) {
          go_ahead();
        } else {
          meeting.sync_beside(go_ahead);
        }
      }
      if (done) break;
      node.advance(next);
    }
    node.end();
    if (node.thread == 0) *a.progress = *a.seen = progress;
  }
}

}  // namespace drench::kokkos_backend::resident
