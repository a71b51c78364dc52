#pragma once
// A step of cloth by a direct solve, to hold the iterations of both methods against.

#include <gtest/gtest.h>

#include <Eigen/SparseCholesky>
#include <cmath>
#include <vector>

#include "base/eigen_vec.hpp"
#include "validation.hpp"

namespace drench::test {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using Eigen::VectorXd;

inline Vector3d node(const std::vector<Vec3>& x, Index n) { return to_eigen(x[at(n)]); }

/// kg
inline double wet_mass(const Model& m, const HostState& s, Index n) {
  return m.mesh.solid_mass[at(n)] + kilograms(m, s.node_liquid[at(n)]);
}

/// One step by Projective Dynamics as it was first published: springs projected one by one, then the linear system
/// solved by Cholesky, again and again. Everything is in shifts u = x − x⁰, those of pinned nodes being 0.
class DirectStep {
 public:
  DirectStep(const Model& m, const HostState& s, double dt) : mesh_(m.mesh), s_(s) {
    row_.reserve(at(mesh_.nodes()));
    for (Index n = 0; n < mesh_.nodes(); ++n) row_.push_back(mesh_.pinned[at(n)] ? -1 : rows_++);
    fixed_ = VectorXd::Zero(3 * rows_);
    add_inertia(m, dt);
    add_springs(m.cloths.front().strain_damping / dt);
    add_hinges();
    Eigen::SparseMatrix<double> matrix(3 * rows_, 3 * rows_);
    matrix.setFromTriplets(entries_.begin(), entries_.end());
    cholesky_.compute(matrix);
    EXPECT_EQ(cholesky_.info(), Eigen::Success);
  }

  /// The shifts after so many iterations that they change no more; `last_change`: by how much of their size they do.
  std::vector<Vector3d> solve(double& last_change) {
    shift_ = VectorXd::Zero(3 * rows_);
    for (int iteration = 0; iteration < 30000; ++iteration) {
      const VectorXd next = cholesky_.solve(with_springs_at_rest_length());
      last_change = (next - shift_).norm() / next.norm();
      shift_ = next;
      if (last_change < 1e-13) break;
    }
    std::vector<Vector3d> shifts;
    shifts.reserve(at(mesh_.nodes()));
    for (Index n = 0; n < mesh_.nodes(); ++n) shifts.push_back(moved(n));
    return shifts;
  }

 private:
  void couple(Index a, Index b, const Matrix3d& block) {
    if (row_[at(a)] < 0 || row_[at(b)] < 0) return;
    for (int i = 0; i < 3; ++i)
      for (int j = 0; j < 3; ++j) entries_.emplace_back(3 * row_[at(a)] + i, 3 * row_[at(b)] + j, block(i, j));
  }
  void push(VectorXd& right, Index n, const Vector3d& force) const {
    if (row_[at(n)] >= 0) right.segment<3>(3 * row_[at(n)]) += force;
  }
  Vector3d moved(Index n) const {
    return row_[at(n)] < 0 ? Vector3d::Zero() : Vector3d(shift_.segment<3>(3 * row_[at(n)]));
  }

  void add_inertia(const Model& m, double dt) {
    for (Index n = 0; n < mesh_.nodes(); ++n) {
      const double mass = wet_mass(m, s_, n) / (dt * dt);
      couple(n, n, mass * Matrix3d::Identity());
      push(fixed_, n,
           mass * (dt * std::exp(-m.cloths.front().damping * dt) * node(s_.node_velocity, n) +
                   dt * dt * to_eigen(m.scene.gravity)));
    }
  }
  /// Without their rest lengths. `damping`: of the rate along a spring, over Δt, 1.
  void add_springs(double damping) {
    for (std::size_t e = 0; e < mesh_.edge.size(); ++e) {
      const auto [a, b] = mesh_.edge[e];
      const Vector3d along = node(s_.node_position, a) - node(s_.node_position, b), direction = along.normalized();
      const Matrix3d block =
          mesh_.edge_stiffness[e] * (Matrix3d::Identity() + damping * direction * direction.transpose());
      couple(a, a, block);
      couple(b, b, block);
      couple(a, b, -block);
      couple(b, a, -block);
      push(fixed_, a, -mesh_.edge_stiffness[e] * along);
      push(fixed_, b, mesh_.edge_stiffness[e] * along);
    }
  }
  void add_hinges() {
    for (std::size_t h = 0; h < mesh_.hinge.size(); ++h) {
      const auto& weight = mesh_.hinge_weight[h];
      Vector3d bend = Vector3d::Zero();
      for (std::size_t a = 0; a < 4; ++a) bend += weight[a] * node(s_.node_position, mesh_.hinge[h][a]);
      for (std::size_t a = 0; a < 4; ++a) {
        const double pull = mesh_.hinge_stiffness[h] * weight[a];
        push(fixed_, mesh_.hinge[h][a], -pull * bend);
        for (std::size_t b = 0; b < 4; ++b)
          couple(mesh_.hinge[h][a], mesh_.hinge[h][b], pull * weight[b] * Matrix3d::Identity());
      }
    }
  }
  /// The forces at u = 0, with the springs' rest lengths along their directions now.
  VectorXd with_springs_at_rest_length() const {
    VectorXd right = fixed_;
    for (std::size_t e = 0; e < mesh_.edge.size(); ++e) {
      const auto [a, b] = mesh_.edge[e];
      const Vector3d along = node(s_.node_position, a) - node(s_.node_position, b) + moved(a) - moved(b);
      const Vector3d rest = mesh_.edge_stiffness[e] * mesh_.edge_length[e] * along.normalized();
      push(right, a, rest);
      push(right, b, -rest);
    }
    return right;
  }

  const ClothMesh& mesh_;
  const HostState& s_;
  std::vector<Index> row_;  // of a free node; −1: pinned
  Index rows_ = 0;
  std::vector<Eigen::Triplet<double>> entries_;
  VectorXd fixed_, shift_;
  Eigen::SimplicialLLT<Eigen::SparseMatrix<double>> cholesky_;
};

}  // namespace drench::test
