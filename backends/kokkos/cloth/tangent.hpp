#pragma once
// The tangent stiffness K of the cloth's implicit step on a host, with what contact does to its rows, and Cholesky
// factors that precondition it (docs/theory/cloth.md, section 8).

#include <memory>
#include <vector>

#include "cloth/block_cholesky.hpp"
#include "cloth/newton_node.hpp"
#include "cloth/tangent_pattern.hpp"

namespace drench::kokkos_backend {

class ClothTangent {
 public:
  ClothTangent(const Cloth& cloth, const ClothSystem& system);
  ClothTangent(ClothTangent&&) = delete;  // held_ points into it
  /// K at x⁰ + `shift` (m): inertia, springs, membranes, strain limits and damping without what is negative in them;
  /// bending.
  void update(const ClothSystem& s, const std::vector<Double3>& shift);
  /// The block of node n.
  Matrix3 own(Index n) const { return own_[at(n)] + pattern_.bending[at(n)] * Matrix3::Identity(); }
  /// Groups of nodes between which there are few entries: the parts of the factor of the edges.
  Index groups() const { return edge_pairs_.cholesky.parts(); }
  Index group(Index n) const { return group_[at(n)]; }
  /// rho −= K times `change` of node n, on the nodes of its group that share an entry with it.
  void subtract_change(Index n, const Column3& change, NodeVector& rho) const;
  /// K times `change` of the nodes of other groups, on node n.
  Column3 from_other_groups(Index n, const NodeVector& change) const;
  /// y = K x, of all rows as contact leaves them (`freedom`) or as they are (null).
  void multiply(const ClothSystem& s, const std::vector<NodeFreedom>& freedom, bool contact_rows, const NodeVector& x,
                NodeVector& y) const;
  /// From now on the factor holds only the pairs of nodes that share an edge: the cheap one.
  void hold_edges() { held_ = &edge_pairs_; }
  /// From now on it holds all pairs, also those that only bending joins, if there is room for them.
  void hold_all(const ClothSystem& s);
  bool holds_all() const { return held_->all; }
  /// The cost of making a factor of all pairs, in iterations of the linear solver, as estimated from the links of a
  /// node; infinite where it would take too much memory.
  double cost_of_all() const { return cost_of_all_; }
  /// The factor F of Q K Q on the pairs that it holds.
  void factor(const ClothSystem& s, const std::vector<NodeFreedom>& freedom);
  /// z = Q F⁻¹ Q r.
  void precondition(const std::vector<NodeFreedom>& freedom, const NodeVector& r, NodeVector& z);

 private:
  /// A block of the factor; stride 0: none.
  struct Target {
    std::uint32_t at = 0;
    Index stride = 0;
  };
  /// A factor and where the blocks of K go in it.
  struct Factor {
    BlockCholesky cholesky;
    bool all = false;  // it holds all pairs that bend
    std::vector<Target> own, link;
    std::vector<Real> bending;  // of each node, N/m: the part of B_nn that belongs to its pairs
  };
  /// K between a node and another that shares an edge with it, with a fourth row of zeros: columns are loaded whole.
  using PairBlock = Eigen::Matrix<Real, 4, 3>;
  NodeGraph pattern_of(const ClothSystem& s, bool all) const;
  void make_room(const ClothSystem& s, Factor& f) const;

  Index nodes_, edges_, triangles_;
  TangentPattern pattern_;
  std::vector<PairBlock> between_;     // of each pair, with its bending
  std::vector<Matrix3> own_, shared_;  // of each node; of each edge, row of its first node
  std::vector<Matrix3> of_triangle_;   // six per triangle: of its corners, of its edges 01, 12, 20
  std::vector<Index> free_, row_of_;   // nodes by the factor's rows; −1: pinned
  std::vector<Index> group_;           // of each node; −1: pinned
  Factor edge_pairs_;                  // or all pairs, where these cost little
  std::unique_ptr<Factor> all_pairs_;  // made when a step is found to need it
  Factor* held_ = &edge_pairs_;
  double cost_of_all_ = 0;
  NodeVector solution_;
};

}  // namespace drench::kokkos_backend
