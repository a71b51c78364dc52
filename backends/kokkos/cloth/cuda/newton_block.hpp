#pragma once
// What the blocks of Newton's method on a GPU work on (newton_kernel.hpp).

#include "cloth/cuda/block_exchange.hpp"
#include "cloth/newton_node.hpp"
#include "cloth/tangent_pattern.hpp"

namespace drench::kokkos_backend::resident {

inline constexpr int newton_threads = 256, newton_lanes = 4;    // of a block; of a node, for its row
inline constexpr int most_patch = sizeof(Real) == 4 ? 34 : 24;  // nodes of which the dense matrix fits in shared memory
inline constexpr int most_rows = 3 * most_patch;
inline constexpr int most_directions = 60;  // of a linear solve
static_assert(most_rows <= newton_threads && newton_threads <= most_threads);

/// What stays the same from step to step: which nodes share blocks, and who works on which.
struct NewtonMesh {
  Index nodes, triangles;
  int patches, colours;
  const Index *order, *patch_start;  // nodes, patch by patch
  const std::uint16_t* colour;       // of each node: no two that share an edge have the same
  const Index *pair_start, *bending_start, *part_start;
  const TangentPair* pair;
  const BendingPair* bending_pair;
  const EdgePart* part;
  const Index *pair_at, *bending_at;  // of each pair: the place of its other node in the order
  const Index* pair_link;             // of each pair: its link
  const Real* bending;                // of each node, N/m: B_nn
};

struct NewtonIterate {
  Double3 *shift, *residual;  // m, N
  NodeNearby* near;           // null without solids
};

struct NewtonArrays {
  NewtonIterate now, next;
  Double3* best;           // shift of the best iterate, m
  Double3* corner_force;   // on the second and the third corner of each triangle, N; the first takes the rest
  Double3* bending_at_x0;  // of each node, N
  Matrix3 *of_triangle, *own, *between;  // N/m; `between`: of each pair, with its bending
  ContactState* state;
  Double3* slip_direction;
  std::uint8_t* touching;
  ZoneNode* zone;        // of each node; those that are not near solids have none
  Column3* zone_change;  // m; this and all below in the order
  NodeFreedom* freedom;
  Matrix3* factor_free;                          // the directions that the inverses were made with
  Column3 *right, *change, *plain, *correction;  // N; m; m, of the iteration before; d_c, m
  Column3 *directions, *images;                  // `most_directions` vectors each
  Real* inverse;                                 // of each patch, m/N
  double* part;                                  // of each block, twice: what dots() adds up
  Real3 *shift, *last_shift;                     // the solver's displacements, m
  bool* is_warm;                                 // there are a tangent and inverses of this time step
  const double* spectral_bound;
  ClothProgress *progress, *seen;
};

struct NewtonRun {
  ClothProgress begin;
  bool first;  // of the solve
  bool warm;   // another call of this time step has gone before
  int most;    // iterations
  double tolerance, floor, mean_edge, margin;
};

/// A block's nodes as one thread sees them, and sums over all blocks.
class NewtonBlock {
 protected:
  __device__ NewtonBlock(const ClothSystem& s, const NewtonMesh& mesh, const NewtonArrays& arrays, const NewtonRun& run)
      : s_(s), m_(mesh), a_(arrays), run_(run), thread_(static_cast<int>(threadIdx.x)) {
    const int block = static_cast<int>(blockIdx.x), blocks = static_cast<int>(gridDim.x);
    first_patch_ = static_cast<int>(std::int64_t(m_.patches) * block / blocks);
    end_patch_ = static_cast<int>(std::int64_t(m_.patches) * (block + 1) / blocks);
    first_ = m_.patch_start[first_patch_];
    count_ = m_.patch_start[end_patch_] - first_;
  }

  template <class Each>
  __device__ void each_own(const Each& each) const {
    for (int i = thread_; i < count_; i += newton_threads) each(m_.order[first_ + i]);
  }
  /// The same with the node's place in the order.
  template <class Each>
  __device__ void each_own_at(const Each& each) const {
    for (Index at = first_ + thread_; at < first_ + count_; at += newton_threads) each(m_.order[at], at);
  }
  /// Some lanes share a node: each(n, lane, place in the order) for all of them at once, n < 0
  /// where there is none.
  template <class Each>
  __device__ void each_own_by_lanes(const Each& each) const {
    constexpr int at_once = newton_threads / newton_lanes;
    for (int first = 0; first < count_; first += at_once) {
      const int i = first + thread_ / newton_lanes;
      each(i < count_ ? m_.order[first_ + i] : Index(-1), thread_ % newton_lanes, first_ + i);
    }
  }
  template <class T>
  static __device__ T over_lanes(T x) {
    for (int apart = 1; apart < newton_lanes; apart *= 2) x += __shfl_xor_sync(all_lanes, x, apart);
    return x;
  }
  static __device__ Double3 over_lanes(const Double3& v) { return {over_lanes(v.x), over_lanes(v.y), over_lanes(v.z)}; }
  static __device__ Column3 over_lanes(const Column3& v) {
    return {over_lanes(v[0]), over_lanes(v[1]), over_lanes(v[2])};
  }

  __device__ void sync() { all_.sync(); }
  /// Σ over all blocks, the same in all threads. Two sums in turn have room each.
  __device__ TwoSums sum(const TwoSums& own) {
    turn_ ^= 1;
    return meeting_.sum(own, reinterpret_cast<TwoSums*>(part_of_turn()));
  }
  __device__ double* part_of_turn() const { return a_.part + turn_ * std::size_t(most_directions + 2) * gridDim.x; }

  /// A lane's part of Σ K_nm x_m over the other nodes.
  template <class Vector>
  __device__ Column3 row_of_others(Index n, int lane, const Vector& x) const {
    return row_of_others(m_.pair_start[n] + lane, m_.pair_start[n + 1], m_.bending_start[n] + lane,
                         m_.bending_start[n + 1], x);
  }
  template <class Vector>
  __device__ Column3 row_of_others(Index pair, Index end, Index bending, Index end_of_bending, const Vector& x) const {
    Column3 sum = Column3::Zero();
    for (; pair < end; pair += newton_lanes) sum += a_.between[pair] * x(m_.pair_at[pair]);
    for (; bending < end_of_bending; bending += newton_lanes)
      sum += m_.bending_pair[bending].bend * x(m_.bending_at[bending]);
    return sum;
  }

  const ClothSystem& s_;
  const NewtonMesh& m_;
  NewtonArrays a_;
  const NewtonRun& run_;
  groups::grid_group all_ = groups::this_grid();
  Meeting<Exchange::barrier> meeting_;
  int thread_;
  int first_patch_, end_patch_;
  Index first_, count_;  // of its nodes, in the order
  int turn_ = 0;
};

}  // namespace drench::kokkos_backend::resident
