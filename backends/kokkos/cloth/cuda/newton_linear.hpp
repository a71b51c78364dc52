#pragma once
// The linear solver of Newton's method on a GPU: generalised conjugate residuals, preconditioned by the dense inverses
// of patches (additive Schwarz; docs/theory/cloth.md, section 8).

#include "cloth/cuda/newton_block.hpp"

namespace drench::kokkos_backend::resident {

class NewtonLinear : public NewtonBlock {
 protected:
  __device__ NewtonLinear(const ClothSystem& s, const NewtonMesh& mesh, const NewtonArrays& arrays,
                          const NewtonRun& run)
      : NewtonBlock(s, mesh, arrays, run) {
    __shared__ Real matrix[most_rows * most_rows];
    matrix_ = matrix;
  }

  static constexpr double enough = 0.2;  // of the goal, also of the linear solve: at the start nothing is left to do

  /// The inverse of each patch's part of Q K Q, with contact's rows.
  __device__ void invert_patches() {
    for (int patch = first_patch_; patch < end_patch_; ++patch) {
      assemble(patch);
      invert(patch_rows(patch));
      if (is_alone()) continue;  // it stays in shared memory
      store(patch);
      __syncthreads();
    }
  }
  /// Does the block have one patch?
  __device__ bool is_alone() const { return end_patch_ - first_patch_ == 1; }
  /// Its inverse stays in shared memory during a call, and in the array from call to call.
  __device__ void load_inverse() {
    if (!is_alone()) return;
    const int numbers = patch_rows(first_patch_) * patch_rows(first_patch_);
    for (int i = thread_; i < numbers; i += newton_threads) matrix_[i] = inverse_of(first_patch_)[i];
  }
  __device__ void keep_inverse() const {
    if (is_alone()) store(first_patch_);
  }
  __device__ int patch_rows(int patch) const {
    return 3 * static_cast<int>(m_.patch_start[patch + 1] - m_.patch_start[patch]);
  }
  __device__ Real* inverse_of(int patch) const { return a_.inverse + std::size_t(patch) * (most_rows * most_rows); }
  __device__ void store(int patch) const {
    const int numbers = patch_rows(patch) * patch_rows(patch);
    for (int i = thread_; i < numbers; i += newton_threads) inverse_of(patch)[i] = matrix_[i];
  }
  __device__ void assemble(int patch) {
    const Index first = m_.patch_start[patch];
    const int rows = patch_rows(patch), nodes = rows / 3;
    for (int i = thread_; i < rows * rows; i += newton_threads) matrix_[i] = 0;
    __syncthreads();
    const auto put = [&](int i, int j, const Matrix3& k) {
      for (int c = 0; c < 3; ++c)
        for (int r = 0; r < 3; ++r) matrix_[(3 * j + c) * rows + 3 * i + r] += k(r, c);
    };
    constexpr int lanes = newton_threads / most_patch;
    const int i = thread_ / lanes, lane = thread_ % lanes;
    if (i < nodes) {
      const Index n = m_.order[first + i];
      const NodeFreedom& f = a_.freedom[n];
      const bool free = !s_.pinned(n);
      if (lane == 0) {
        a_.factor_free[n] = f.free;
        Matrix3 own = free ? a_.own[n] : Matrix3(Matrix3::Identity());
        if (free && !f.all) {
          own += f.turning;
          const Real mean = own.trace() / 3;
          own = (f.free * own * f.free + mean * (Matrix3::Identity() - f.free)).eval();
        }
        put(i, i, own);
      }
      const auto add = [&](Index other, Index at, Matrix3 k) {
        if (at < first || at >= first + nodes || other == n || s_.pinned(other)) return;
        if (!f.all) k = (f.free * k).eval();
        if (!a_.freedom[other].all) k = (k * a_.freedom[other].free).eval();
        put(i, static_cast<int>(at - first), k);
      };
      if (free) {
        for (Index p = m_.pair_start[n] + lane; p < m_.pair_start[n + 1]; p += lanes)
          add(m_.pair[p].other, m_.pair_at[p], a_.between[p]);
        for (Index b = m_.bending_start[n] + lane; b < m_.bending_start[n + 1]; b += lanes)
          add(m_.bending_pair[b].other, m_.bending_at[b], m_.bending_pair[b].bend * Matrix3::Identity());
      }
    }
    __syncthreads();
  }
  /// The matrix in shared memory becomes its inverse: Gauss-Jordan, whose pivots need no choice, because it is
  /// positive. Each thread keeps every 16th number of every 16th row in registers.
  __device__ void invert(int rows) {
    constexpr int side = 16, each = (most_rows + side - 1) / side;
    static_assert(side * side == newton_threads);
    __shared__ Real row[2][side * each], column_of[2][side * each];
    const int tx = thread_ % side, ty = thread_ / side;
    Real own[each][each];
#pragma unroll
    for (int r = 0; r < each; ++r)
#pragma unroll
      for (int c = 0; c < each; ++c) {
        const int i = side * r + ty, j = side * c + tx;
        own[r][c] = i < rows && j < rows ? matrix_[j * rows + i] : Real(0);
      }
#pragma unroll
    for (int part = 0; part < each; ++part) {
#pragma unroll 1
      for (int p = side * part; p < side * (part + 1) && p < rows; ++p) {
        const int of_part = p % side, turn = p % 2;
        if (ty == of_part)
#pragma unroll
          for (int c = 0; c < each; ++c) row[turn][side * c + tx] = own[part][c];
        if (tx == of_part)
#pragma unroll
          for (int r = 0; r < each; ++r) column_of[turn][side * r + ty] = own[r][part];
        __syncthreads();
        const Real at = row[turn][p], pivot = at > 0 ? 1 / at : Real(0);
        Real scaled[each];
#pragma unroll
        for (int c = 0; c < each; ++c) scaled[c] = pivot * row[turn][side * c + tx];
#pragma unroll
        for (int r = 0; r < each; ++r) {
          const Real lost = column_of[turn][side * r + ty];
#pragma unroll
          for (int c = 0; c < each; ++c) own[r][c] -= lost * scaled[c];
          if (tx == of_part) own[r][part] = -pivot * lost;
        }
        if (ty == of_part) {
#pragma unroll
          for (int c = 0; c < each; ++c) own[part][c] = scaled[c];
          if (tx == of_part) own[part][part] = pivot;
        }
      }
    }
    __syncthreads();
#pragma unroll
    for (int r = 0; r < each; ++r)
#pragma unroll
      for (int c = 0; c < each; ++c) {
        const int i = side * r + ty, j = side * c + tx;
        if (i < rows && j < rows) matrix_[j * rows + i] = own[r][c];
      }
    __syncthreads();
  }

  /// z = Q A⁻¹ Q r of the block's own patches.
  __device__ void precondition(const Column3* r, Column3* z) {
    __shared__ Real from[most_rows], half[most_rows];
    for (int patch = first_patch_; patch < end_patch_; ++patch) {
      const Index first = m_.patch_start[patch];
      const int rows = patch_rows(patch), nodes = rows / 3;
      for (int i = thread_; i < nodes; i += newton_threads) {
        const Index n = m_.order[first + i];
        Column3 x = r[first + i];
        if (!a_.freedom[n].all) x = (a_.freedom[n].free * x).eval();
        for (int c = 0; c < 3; ++c) from[3 * i + c] = x[c];
      }
      __syncthreads();
      const Real* const inverse = is_alone() ? matrix_ : inverse_of(patch);
      constexpr int group = newton_threads / 2;
      const int i = thread_ % group, part = thread_ / group, middle = rows / 2;
      Real sum = 0;
      if (i < rows) {
        const int end = part == 0 ? middle : rows;
#pragma unroll 8
        for (int j = part == 0 ? 0 : middle; j < end; ++j) sum += inverse[j * rows + i] * from[j];
      }
      if (i < rows && part == 1) half[i] = sum;
      __syncthreads();
      if (i < rows && part == 0) from[i] = sum + half[i];
      __syncthreads();
      for (int k = thread_; k < nodes; k += newton_threads) {
        const Index n = m_.order[first + k];
        Column3 x(from[3 * k], from[3 * k + 1], from[3 * k + 2]);
        if (!a_.freedom[n].all) x = (a_.freedom[n].free * x).eval();
        z[first + k] = x;
      }
      __syncthreads();
    }
  }

  /// What a lane keeps of its node's row during a linear solve: the first of its blocks and bending pairs.
  struct KeptRow {
    static constexpr int pairs = 2, bends = 4;
    Matrix3 block[pairs];
    Real bend[bends];
    Index pair_at[pairs], bend_at[bends];
    Index pair, end, bending, end_of_bending;  // the rest
  };
  __device__ KeptRow keep_row() const {
    KeptRow row;
    const int i = thread_ / newton_lanes;
    const Index n = i < count_ ? m_.order[first_ + i] : 0;
    const bool free = i < count_ && !s_.pinned(n);
    row.pair = m_.pair_start[n] + thread_ % newton_lanes;
    row.bending = m_.bending_start[n] + thread_ % newton_lanes;
    row.end = free ? m_.pair_start[n + 1] : 0;
    row.end_of_bending = free ? m_.bending_start[n + 1] : 0;
#pragma unroll
    for (int k = 0; k < KeptRow::pairs; ++k, row.pair += newton_lanes) {
      const bool has = row.pair < row.end;
      row.block[k] = has ? a_.between[row.pair] : Matrix3(Matrix3::Zero());
      row.pair_at[k] = has ? m_.pair_at[row.pair] : first_;
    }
#pragma unroll
    for (int k = 0; k < KeptRow::bends; ++k, row.bending += newton_lanes) {
      const bool has = row.bending < row.end_of_bending;
      row.bend[k] = has ? m_.bending_pair[row.bending].bend : Real(0);
      row.bend_at[k] = has ? m_.bending_at[row.bending] : first_;
    }
    return row;
  }
  __device__ Column3 times_kept(const KeptRow& row, const Column3* x) const {
    Column3 of_pair[KeptRow::pairs], of_bend[KeptRow::bends];
#pragma unroll
    for (int k = 0; k < KeptRow::pairs; ++k) of_pair[k] = x[row.pair_at[k]];
#pragma unroll
    for (int k = 0; k < KeptRow::bends; ++k) of_bend[k] = x[row.bend_at[k]];
    Column3 sum = row_of_others(row.pair, row.end, row.bending, row.end_of_bending, [x](Index at) { return x[at]; });
#pragma unroll
    for (int k = 0; k < KeptRow::pairs; ++k) sum += row.block[k] * of_pair[k];
#pragma unroll
    for (int k = 0; k < KeptRow::bends; ++k) sum += row.bend[k] * of_bend[k];
    return sum;
  }

  /// y = K x, of the block's own rows, as contact leaves them. `kept`: of the block's nodes, if they are few.
  __device__ void multiply(const Column3* x, Column3* y, const KeptRow& kept) const {
    const bool few = count_ <= newton_threads / newton_lanes;
    each_own_by_lanes([&](Index n, int lane, Index at) {
      const bool free = n >= 0 && !s_.pinned(n), first = free && lane == 0;
      const Matrix3 own = first ? a_.own[n] : Matrix3(Matrix3::Zero());
      const Column3 here = first ? x[at] : Column3(Column3::Zero());
      Column3 sum = Column3::Zero();
      if (few)
        sum = times_kept(kept, x);
      else if (free)
        sum = row_of_others(n, lane, [x](Index other) { return x[other]; });
      sum = over_lanes(sum);
      if (n < 0 || lane != 0) return;
      if (!free) {
        y[at].setZero();
        return;
      }
      const NodeFreedom& f = a_.freedom[n];
      sum += own * here;
      if (!f.all) {
        sum += f.turning * here;
        sum = (f.free * sum + f.normal.dot(sum) * f.drag).eval();
      }
      y[at] = sum;
    });
  }

  /// change := d with K d = right by generalised conjugate residuals, + d_c.
  __device__ void solve_linear() {
    const KeptRow kept = keep_row();
    linear_ = 0;
    multiply(a_.correction, a_.images, kept);
    __syncthreads();
    TwoSums norms;
    each_own_at([&](Index n, Index at) {
      Column3 r = a_.right[at] - a_.images[at];
      if (!a_.freedom[n].all) r = (a_.freedom[n].free * r).eval();
      a_.right[at] = r;
      a_.change[at] = a_.correction[at];
      norms.first += double(r.norm());
      norms.second += double(r.squaredNorm());
    });
    norms = sum(norms);
    if (!(norms.first > 0)) return;
    // The sum of the nodes' norms is taken to fall with the square root of the sum of squares.
    const double part = larger(forcing, enough * goal_ / norms.first), target = part * part * norms.second;
    double square = norms.second;
    for (int k = 0; k < most_directions && square > target; ++k) {
      Column3* const z = a_.directions + std::size_t(k) * m_.nodes;
      Column3* const q = a_.images + std::size_t(k) * m_.nodes;
      precondition(a_.right, z);
      sync();
      multiply(z, q, kept);
      __syncthreads();
      const double* const product = dots(k);
      double norm = product[k];
      for (int j = 0; j < k; ++j) norm -= product[j] * product[j];
      if (!(norm > 1e-10 * product[k])) return;
      norm = std::sqrt(norm);
      const double along = product[k + 1] / norm;
      step_along(k, product, Real(1 / norm), Real(along));
      square -= along * along;
      ++linear_;
      if (along * along <= no_progress * square) return;
    }
  }
  /// The block's numbers of a vector in the order.
  __device__ Real* numbers(Column3* x) const { return reinterpret_cast<Real*>(x + first_); }
  /// Takes from direction k what lies along those before it, and goes along it by `a`.
  __device__ void step_along(int k, const double* product, Real scale, Real a) const {
    const int count = 3 * count_;
    for (int i = thread_; i < 2 * count; i += newton_threads) {
      const bool image = i >= count;
      Real* const vectors = numbers(image ? a_.images : a_.directions) + (image ? i - count : i);
      const std::size_t stride = 3 * std::size_t(m_.nodes);
      Real x = vectors[std::size_t(k) * stride];
#pragma unroll 4
      for (int j = 0; j < k; ++j) x -= Real(product[j]) * vectors[std::size_t(j) * stride];
      x *= scale;
      vectors[std::size_t(k) * stride] = x;
      if (image)
        numbers(a_.right)[i - count] -= a * x;
      else
        numbers(a_.change)[i] += a * x;
    }
    __syncthreads();
  }
  static __device__ double of_warp(double x) {
    for (int apart = warp / 2; apart > 0; apart /= 2) x += __shfl_down_sync(all_lanes, x, apart);
    return x;
  }
  /// Of image k with those before it, with itself, and with the residual.
  __device__ const double* dots(int k) {
    __shared__ double total[most_directions + 2];
    turn_ ^= 1;
    double* const part = part_of_turn();
    const Real* const q = numbers(a_.images + std::size_t(k) * m_.nodes);
    for (int j = thread_ / warp; j < k + 2; j += newton_threads / warp) {
      const Real* const with = numbers(j <= k ? a_.images + std::size_t(j) * m_.nodes : a_.right);
      double own = 0;
      for (int i = thread_ % warp; i < 3 * count_; i += warp) own += double(q[i] * with[i]);
      own = of_warp(own);
      if (thread_ % warp == 0) part[std::size_t(j) * gridDim.x + blockIdx.x] = own;
    }
    sync();
    for (int j = thread_ / warp; j < k + 2; j += newton_threads / warp) {
      double every = 0;
      for (unsigned b = thread_ % warp; b < gridDim.x; b += warp)
        every += __ldcg(part + std::size_t(j) * gridDim.x + b);
      every = of_warp(every);
      if (thread_ % warp == 0) total[j] = every;
    }
    __syncthreads();
    return total;
  }

  Real* matrix_;     // of a patch, in shared memory
  double goal_ = 0;  // of the residual, N
  int linear_ = 0;   // iterations of the last linear solve
};

}  // namespace drench::kokkos_backend::resident
