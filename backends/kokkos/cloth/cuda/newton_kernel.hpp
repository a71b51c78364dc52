#pragma once
// Newton's method for the cloth in one kernel that stays on the device (docs/theory/cloth.md, section 8). Each block
// has the nodes of one patch or of several; a patch's part of the tangent stiffness is inverted as a dense matrix and
// preconditions the linear solver (additive Schwarz).

#include "cloth/cuda/newton_linear.hpp"
#include "cloth/tangent_blocks.hpp"

namespace drench::kokkos_backend::resident {

/// The kernel as one thread sees it.
class NewtonKernel : NewtonLinear {
 public:
  __device__ NewtonKernel(const ClothSystem& s, const NewtonMesh& mesh, const NewtonArrays& arrays,
                          const NewtonRun& run)
      : NewtonLinear(s, mesh, arrays, run), sight_{run.mean_edge, run.margin} {}

  __device__ void solve() {
    ClothProgress progress = run_.first ? run_.begin : *a_.progress;
    if (run_.first) progress.rho = smaller(progress.rho, *a_.spectral_bound);
    const int most = progress.newton_failed ? most_after_failure : most_iterations;
    int end = run_.most < most ? run_.most : most;
    warm_ = run_.warm && *a_.is_warm;
    begin();
    if (warm_) load_inverse();
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
      const bool anew = !warm_ || changed_ > many_changed || spent > inverses_cost;
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
    if (warm_) keep_inverse();
    progress.iterations += k;
    progress.residual = best;
    if (!(best <= 1) && end > 0) progress.newton_failed = true;
    if (blockIdx.x == 0 && thread_ == 0) {
      *a_.progress = *a_.seen = progress;
      *a_.is_warm = warm_;
    }
  }

 private:
  static constexpr int inverses_cost = 3;        // iterations of the linear solver that take as long as new inverses
  static constexpr int most_after_failure = 10;  // iterations of a call, where another one has failed in this solve

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
      // Nodes of a colour that bending joins read each other's previous values.
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

  SolidSight sight_;
  bool warm_ = false;
  double near_ = 0, changed_ = 0, length_ = 1;  // nodes; nodes; of a step
};

__global__ void __launch_bounds__(newton_threads, 1)
    newton(ClothSystem s, NewtonMesh mesh, NewtonArrays arrays, NewtonRun run) {
  NewtonKernel(s, mesh, arrays, run).solve();
}

}  // namespace drench::kokkos_backend::resident
