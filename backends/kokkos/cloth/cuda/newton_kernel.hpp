#pragma once
// Newton's method for the cloth in one kernel that stays on the device (docs/theory/cloth.md, section 8). Each block
// has the nodes of one patch or of several; a patch's part of the tangent stiffness is inverted as a dense matrix and
// preconditions the linear solver (additive Schwarz).

#include "cloth/cuda/block_exchange.hpp"
#include "cloth/newton_node.hpp"
#include "cloth/solver.hpp"
#include "cloth/tangent_blocks.hpp"

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
  const std::uint16_t* place;        // of each node in its patch
  const Index* patch_of;             // of each node
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
  Column3* zone_change;  // m: of all sweeps; this and all below in the order
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

/// The kernel as one thread sees it.
class NewtonKernel {
 public:
  __device__ NewtonKernel(const ClothSystem& s, const NewtonMesh& mesh, const NewtonArrays& arrays,
                          const NewtonRun& run)
      : s_(s),
        m_(mesh),
        a_(arrays),
        run_(run),
        thread_(static_cast<int>(threadIdx.x)),
        sight_{run.mean_edge, run.margin} {
    __shared__ Real matrix[most_rows * most_rows];
    matrix_ = matrix;
    const int block = static_cast<int>(blockIdx.x), blocks = static_cast<int>(gridDim.x);
    first_patch_ = static_cast<int>(std::int64_t(m_.patches) * block / blocks);
    end_patch_ = static_cast<int>(std::int64_t(m_.patches) * (block + 1) / blocks);
    first_ = m_.patch_start[first_patch_];
    count_ = m_.patch_start[end_patch_] - first_;
  }

  __device__ void solve() {
    ClothProgress progress = run_.first ? run_.begin : *a_.progress;
    if (run_.first) progress.rho = smaller(progress.rho, *a_.spectral_bound);
    const int most = progress.newton_failed ? most_after_failure : most_iterations;
    int end = run_.most < most ? run_.most : most;
    warm_ = run_.warm && *a_.is_warm;
    begin();
    const bool alone = end_patch_ - first_patch_ == 1;
    if (warm_ && alone) {
      const int numbers = patch_rows(first_patch_) * patch_rows(first_patch_);
      for (int i = thread_; i < numbers; i += newton_threads) matrix_[i] = inverse_of(first_patch_)[i];
    }
    double over = measure(a_.now), best = over, past[4] = {};
    int toggled = 0, k = 0, spent = 0, when_new = 0;  // iterations of the linear solver, as in newton.cpp
    bool saved = false;
    if (is_for_jacobi(over, progress.rho)) end = 0;
    for (; k < end && !(over <= (k > 0 ? 1 : enough)); ++k) {
      const bool slow = k >= slow_after && over > 0.5 * past[(k - 3) % 4];
      const bool late = (slow && k >= stands_after && k / 4 % 2 == 1) || (k >= late_after && toggled > many_toggled);
      past[k % 4] = over;
      if (k > 0 || !warm_) update_tangent();
      if (s_.solids.count > 0) find_touching(late);
      toggled = set_rows();
      const bool anew = !warm_ || changed_ > many_changed || spent > factor_cost;
      if (anew) invert_patches();
      warm_ = true;
      solve_linear();
      if (anew) {
        when_new = linear_;
        spent = 0;
      } else {
        spent += linear_ > when_new ? linear_ - when_new : 0;
      }
      choose_length(slow);
      over = move(over);
      const NewtonIterate kept = a_.now;
      a_.now = a_.next;
      a_.next = kept;
      if (over > best) continue;
      best = over;
      saved = over > 1;
      if (saved) each_own([&](Index n) { a_.best[n] = a_.now.shift[n]; });
    }
    each_own([&](Index n) {
      if (s_.pinned(n)) return;
      a_.last_shift[n] = a_.shift[n] = narrow(saved && over > 1 ? a_.best[n] : a_.now.shift[n]);
    });
    if (warm_ && alone) store(first_patch_);
    progress.iterations += k;
    progress.residual = best;
    if (!(best <= 1) && end > 0) progress.newton_failed = true;
    if (blockIdx.x == 0 && thread_ == 0) {
      *a_.progress = *a_.seen = progress;
      *a_.is_warm = warm_;
    }
  }

 private:
  static constexpr int factor_cost = 3;  // of the inverses, in iterations of the linear solver
  static constexpr int most_iterations = 40, most_after_failure = 10;  // of a call; where another one has failed
  static constexpr Index many_changed = 20;  // nodes with other free directions than the inverses': these are made anew
  static constexpr Real other_directions = Real(0.02);  // squared: from there on they differ
  static constexpr int slow_after = 4, stands_after = 12, late_after = 6, many_toggled = 40;  // as in newton.cpp
  static constexpr double enough = 0.2;  // of the goal, also of the linear solve: at the start nothing is left to do
  static constexpr double forcing = 0.05, same_way = 0.3, longest = 32, most_growth = 2;  // likewise
  static constexpr int most_halvings = 3;

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

  /// Are Jacobi iterations expected to take less time than one of Newton's? By the decay of Chebyshev's weights, which
  /// contact slows down.
  __device__ bool is_for_jacobi(double over, double rho) const {
    constexpr int few = sizeof(Real) == 4 ? 90 : 60, few_with_triangles = few / 2;
    if (!(over > 1) || !(rho > 0 && rho < 1)) return false;
    const double needed = plain_iterations + std::log(2 * over) / std::acosh(1 / rho);
    return needed * (near_ > 0 ? 4 : 1) < (m_.triangles > 0 ? few_with_triangles : few);
  }

  __device__ void begin() {
    each_own_by_lanes([&](Index n, int lane, Index) {
      Double3 bending;
      if (n >= 0 && !s_.pinned(n)) bending = bending_force(n, lane, [&](Index m) { return widen(s_.start(m)); });
      bending = over_lanes(bending);
      if (n < 0 || lane != 0) return;
      a_.bending_at_x0[n] = bending;
      Double3 shift = widen(a_.shift[n]);
      if (!s_.pinned(n)) {
        if (s_.solids.count > 0) shift = project_out(s_.solids, s_.start(n), shift, s_.clearance(n));
        if (!warm_) {
          a_.state[n] = ContactState::apart;
          a_.factor_free[n].setIdentity();
        }
      }
      a_.now.shift[n] = shift;
      a_.next.shift[n] = shift;
      a_.touching[n] = 0;
      if (s_.solids.count > 0) a_.now.near[n].count = a_.next.near[n].count = 0;
    });
    TwoSums goal;
    each_own([&](Index n) {
      if (!s_.pinned(n)) goal.first += ClothSystem::goal(s_.terms(n), run_.tolerance, run_.floor);
    });
    goal_ = sum(goal).first;
  }

  template <class Vector>
  __device__ Double3 bending_force(Index n, int lane, const Vector& v) const {
    const Double3 here = v(n);
    Double3 force;
    for (Index p = m_.pair_start[n] + lane; p < m_.pair_start[n + 1]; p += newton_lanes)
      force += double(m_.pair[p].bend) * (here - v(m_.pair[p].other));
    for (Index b = m_.bending_start[n] + lane; b < m_.bending_start[n + 1]; b += newton_lanes)
      force += double(m_.bending_pair[b].bend) * (here - v(m_.bending_pair[b].other));
    return force;
  }

  /// The residual of an iterate over its goal; who is near solids (docs/theory/cloth.md, Eqs. 14, 20).
  __device__ double measure(const NewtonIterate& at) {
    sync();
    const Double3* const u = at.shift;
    for (Index t = static_cast<Index>(blockIdx.x) * newton_threads + thread_; t < m_.triangles;
         t += static_cast<Index>(gridDim.x) * newton_threads) {
      const Columns<double> stress =
          s_.triangle_stress(t, u[s_.triangle(3 * t)], u[s_.triangle(3 * t + 1)], u[s_.triangle(3 * t + 2)]);
      for (Index c = 1; c < 3; ++c)
        a_.corner_force[2 * t + c - 1] = corner_force(stress, corner_gradient(s_.triangle_shape(t), c));
    }
    sync();
    each_own_by_lanes([&](Index n, int lane, Index) {
      Double3 force;
      if (n >= 0 && !s_.pinned(n)) force = elastic_force(n, lane, u);
      force = over_lanes(force);
      if (n < 0 || lane != 0) return;
      if (s_.pinned(n))
        at.residual[n] = {};
      else
        at.residual[n] =
            double(s_.mass(n)) * double(s_.inverse_dt2) * (widen(s_.target(n)) - u[n]) + (force + a_.bending_at_x0[n]);
    });
    __syncthreads();
    TwoSums left;
    each_own([&](Index n) {
      if (s_.pinned(n)) return;
      Double3 of_node = at.residual[n];
      if (s_.solids.count > 0) {
        NodeNearby& near = at.near[n];
        const NodeTerms t = s_.terms(n);
        see_solids(s_, t, sight_, u[n], at.residual[n], near);
        of_node = near.left;
        if (near.contact.press > 0) of_node = ClothSystem::unbalanced(t, u[n], near.contact, near.left, &near.blocked);
        if (near.count > 0) left.second += 1;
      }
      left.first += norm(of_node);
    });
    left = sum(left);
    near_ = left.second;
    constexpr double lost = 1e100;  // also where numbers are not finite
    const double over = left.first == 0 ? 0 : left.first / goal_;
    return over < lost ? over : lost;
  }
  __device__ Double3 elastic_force(Index n, int lane, const Double3* u) const {
    Double3 force = bending_force(n, lane, [u](Index m) { return u[m]; });
    for (Index p = m_.pair_start[n] + lane; p < m_.pair_start[n + 1]; p += newton_lanes) {
      Link spring = s_.link(m_.pair_link[p]);
      if (!(spring.stiffness > 0)) continue;
      spring.bend = 0;
      const Real rate = s_.strain_damping_rate(n);
      const Real damping =
          rate > 0 ? strain_damping(s_.start(n) - s_.start(spring.other), spring.stiffness, rate) : Real(0);
      ClothSystem::add_link(force, spring, widen(s_.start(n)) - widen(s_.start(spring.other)), u[n] - u[spring.other],
                            0.0, damping);
    }
    if (s_.triangle_start.exist())
      for (Index i = s_.triangle_start(n) + lane; i < s_.triangle_start(n + 1); i += newton_lanes) {
        const Index t = s_.triangle_item(i) / 4, corner = s_.triangle_item(i) % 4;
        if (corner == 0)
          force -= a_.corner_force[2 * t] + a_.corner_force[2 * t + 1];
        else
          force += a_.corner_force[2 * t + corner - 1];
      }
    return force;
  }

  /// K at the iterate. Rows of a block's own nodes are read by that block alone.
  __device__ void update_tangent() {
    const Double3* const u = a_.now.shift;
    for (Index t = static_cast<Index>(blockIdx.x) * newton_threads + thread_; t < m_.triangles;
         t += static_cast<Index>(gridDim.x) * newton_threads)
      triangle_blocks(s_, t, u, a_.of_triangle + 6 * t);
    sync();
    each_own_by_lanes([&](Index n, int lane, Index) {
      if (n < 0 || s_.pinned(n)) return;
      if (lane == 0) {
        Matrix3 own = own_block(s_, n, u, a_.of_triangle);
        own.diagonal().array() += m_.bending[n];
        a_.own[n] = own;
      }
      for (Index p = m_.pair_start[n] + lane; p < m_.pair_start[n + 1]; p += newton_lanes) {
        const TangentPair pair = m_.pair[p];
        const Link link = s_.link(m_.pair_link[p]);
        const EdgePart* const part = m_.part + m_.part_start[pair.edge / 2];
        const EdgePart* const end = m_.part + m_.part_start[pair.edge / 2 + 1];
        Matrix3 block = edge_block(s_, n, link, part, end, u, a_.of_triangle, pair.edge % 2 == 1);
        block.diagonal().array() += pair.bend;
        a_.between[p] = block;
      }
    });
    __syncthreads();
  }

  /// A sweep of Gauss-Seidel over the block's nodes near solids, colour by colour: which of their planes do they touch?
  __device__ void find_touching(bool late) {
    each_own_at([&](Index n, Index at) {
      a_.touching[n] = 0;
      a_.zone_change[at].setZero();
      const NodeNearby& near = a_.now.near[n];
      if (!s_.pinned(n) && near.count > 0)
        a_.zone[n] = zone_node(s_.terms(n), n, near, a_.now.shift[n], a_.now.residual[n], a_.own[n], a_.state[n]);
    });
    if (!(near_ > 0)) return;
    __syncthreads();
    for (int colour = 0; colour < m_.colours; ++colour) {
      each_own_by_lanes([&](Index n, int lane, Index at) {
        const bool mine = n >= 0 && m_.colour[n] == colour && !s_.pinned(n) && a_.now.near[n].count > 0;
        Column3 lost = Column3::Zero();
        if (mine)
          lost = row_of_others(n, lane, [&](Index other) {
            const bool here = other >= first_ && other < first_ + count_;
            return here ? a_.zone_change[other] : Column3(Column3::Zero());
          });
        lost = over_lanes(lost);
        if (!mine || lane != 0) return;
        const Column3 r = column(a_.now.residual[n]) - lost, none = Column3::Zero();
        a_.change[at] = zone_step(a_.zone[n], a_.now.near[n], s_.friction(n), r, none, a_.touching[n]);
      });
      // Bending joins some nodes of a colour: they see each other as before.
      __syncthreads();
      each_own_at([&](Index n, Index at) {
        if (m_.colour[n] == colour && !s_.pinned(n) && a_.now.near[n].count > 0) a_.zone_change[at] = a_.change[at];
      });
      __syncthreads();
    }
    if (!late) return;
    each_own([&](Index n) {
      if (!s_.pinned(n) && a_.now.near[n].count > 0 && lies_pressed(s_.terms(n), a_.now.near[n], a_.now.residual[n]))
        a_.touching[n] = 1;
    });
    __syncthreads();
  }
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

  /// Who sticks and who slips. Returns how many nodes have changed their state.
  __device__ int set_rows() {
    TwoSums changes;
    each_own_at([&](Index n, Index at) {
      const ContactState before = a_.state[n];
      const NodeNearby* const near = s_.solids.count > 0 ? a_.now.near + n : nullptr;
      const ContactRow row =
          contact_row(s_, n, a_.touching[n], near, a_.now.shift[n], a_.now.residual[n], before, a_.slip_direction[n]);
      a_.freedom[n] = row.freedom;
      a_.right[at] = row.right;
      a_.correction[at] = row.correction;
      a_.state[n] = row.state;
      if (row.state != before) changes.first += 1;
      if ((row.freedom.free - a_.factor_free[n]).squaredNorm() > other_directions) changes.second += 1;
    });
    changes = sum(changes);
    changed_ = changes.second;
    return static_cast<int>(changes.first);
  }

  /// The inverse of each patch's part of Q K Q, with contact's rows.
  __device__ void invert_patches() {
    for (int patch = first_patch_; patch < end_patch_; ++patch) {
      assemble(patch);
      invert(patch_rows(patch));
      if (end_patch_ - first_patch_ == 1) continue;  // it stays in shared memory
      store(patch);
      __syncthreads();
    }
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
      const auto add = [&](Index other, Matrix3 k) {
        if (m_.patch_of[other] != patch || other == n || s_.pinned(other)) return;
        if (!f.all) k = (f.free * k).eval();
        if (!a_.freedom[other].all) k = (k * a_.freedom[other].free).eval();
        put(i, m_.place[other], k);
      };
      if (free) {
        for (Index p = m_.pair_start[n] + lane; p < m_.pair_start[n + 1]; p += lanes)
          add(m_.pair[p].other, a_.between[p]);
        for (Index b = m_.bending_start[n] + lane; b < m_.bending_start[n + 1]; b += lanes)
          add(m_.bending_pair[b].other, m_.bending_pair[b].bend * Matrix3::Identity());
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
      const Real* const inverse = end_patch_ - first_patch_ == 1 ? matrix_ : inverse_of(patch);
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
      if (along * along <= 1e-8 * square) return;
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
      for (int apart = warp / 2; apart > 0; apart /= 2) own += __shfl_down_sync(all_lanes, own, apart);
      if (thread_ % warp == 0) part[std::size_t(j) * gridDim.x + blockIdx.x] = own;
    }
    sync();
    for (int j = thread_ / warp; j < k + 2; j += newton_threads / warp) {
      double every = 0;
      for (unsigned b = thread_ % warp; b < gridDim.x; b += warp)
        every += __ldcg(part + std::size_t(j) * gridDim.x + b);
      for (int apart = warp / 2; apart > 0; apart /= 2) every += __shfl_down_sync(all_lanes, every, apart);
      if (thread_ % warp == 0) total[j] = every;
    }
    __syncthreads();
    return total;
  }

  /// In a buckling sheet the tangent is too stiff: all steps point the same way and are too short (newton.cpp).
  __device__ void choose_length(bool slow) {
    double turn = 0;
    if (slow) {
      TwoSums squares, product;
      each_own_at([&](Index, Index at) {
        squares.first += double(a_.change[at].squaredNorm());
        squares.second += double(a_.plain[at].squaredNorm());
        product.first += double(a_.change[at].dot(a_.plain[at]));
      });
      squares = sum(squares);
      product = sum(product);
      const double lengths = std::sqrt(squares.first * squares.second);
      turn = lengths > 0 ? product.first / lengths : 0;
    }
    length_ = turn > same_way ? smaller(2 * length_, longest) : turn < 0 ? 0.5 : 1.0;
    each_own_at([&](Index, Index at) { a_.plain[at] = a_.change[at]; });
  }

  /// The next iterate, along the change; returns its residual over the goal.
  __device__ double move(double before) {
    double length = length_;
    for (int halvings = 0;; ++halvings) {
      each_own_at([&](Index n, Index at) {
        if (s_.pinned(n)) return;
        Double3 to = a_.now.shift[n];
        Double3 by = length * in_double(a_.change[at]);
        if (a_.touching[n] != 0) by = within_planes(s_, s_.terms(n), a_.now.near[n], a_.touching[n], to, by);
        to += by;
        if (s_.solids.count > 0) to = project_out(s_.solids, s_.start(n), to, s_.clearance(n));
        a_.next.shift[n] = to;
      });
      const double over = measure(a_.next);
      if (over <= most_growth * before || over <= 1 || halvings == most_halvings) return over;
      length *= 0.5;
    }
  }

  const ClothSystem& s_;
  const NewtonMesh& m_;
  NewtonArrays a_;
  const NewtonRun& run_;
  groups::grid_group all_ = groups::this_grid();
  Meeting<Exchange::barrier> meeting_;
  int thread_;
  SolidSight sight_;
  int first_patch_, end_patch_;
  Index first_, count_;  // of its nodes, in the order
  Real* matrix_;         // of a patch, in shared memory
  int turn_ = 0;
  int linear_ = 0;  // iterations of the last linear solve
  bool warm_ = false;
  double goal_ = 0, near_ = 0, changed_ = 0, length_ = 1;  // N; nodes; nodes; of a step
};

__global__ void __launch_bounds__(newton_threads, 1)
    newton(ClothSystem s, NewtonMesh mesh, NewtonArrays arrays, NewtonRun run) {
  NewtonKernel(s, mesh, arrays, run).solve();
}

}  // namespace drench::kokkos_backend::resident
