#pragma once
// The cloth's implicit step by Newton's method on a host, or on the host of a GPU where the iterations there do not
// converge; contact with solids as an active set of nodes that stick and that slip. All arrays are the host's. Law:
// docs/theory/cloth.md, sections 8 and 11.

#include <vector>

#include "cloth/anderson.hpp"
#include "cloth/exact_residual.hpp"
#include "cloth/newton_node.hpp"
#include "cloth/tangent.hpp"

namespace drench::kokkos_backend {

/// Newton's method, and what it keeps from solve to solve of one time step: the factor, and who sticks. Nothing is
/// handed from one time step to the next.
class NewtonCloth {
 public:
  NewtonCloth(const Cloth& cloth, const ClothSystem& system);
  /// Begins a solve. `pushes_bodies`: do dynamic bodies feel the cloth?
  void prepare(const Cloth& cloth, const ClothSystem& system, bool pushes_bodies);
  /// The solve goes on from displacements that others have changed.
  void begin_anew() { fresh_ = true; }
  /// Iterates until the residual is within its goal, at least once and `most` times at most; from `displacement` (m) at
  /// the first call of a solve, and then from where the last call ended. False: it has not converged, and other
  /// iterations have to go on.
  bool run(const Entries<const Real3>& displacement, const ClothSystem& s, ClothProgress& progress, int most,
           double tolerance);
  /// Writes the result of the last call to `displacement`, m; pinned nodes keep what they have.
  void write_result(const ClothSystem& s, const Entries<Real3>& displacement) const;

 private:
  using Vectors = std::vector<Double3>;
  /// An iterate and all that is known of it.
  struct Iterate {
    Vectors shift, elastic, residual;  // m; N, N
    bool has_elastic = false;          // of this shift
    std::vector<NodeNearby> near;      // solids
    NodeVector left;                   // what contact and friction leave of the residual, N
    double over_goal = 0;              // its sum over the goal: converged if ≤ 1
  };
  /// Where a node was asked how far the nearest solid is, m, and by how much that was beyond reach.
  struct Away {
    Double3 shift;
    double room = 0;
  };
  // newton.cpp
  double goal_of(const ClothSystem& s, double tolerance);
  /// Evaluates an iterate, whose elastic forces may be known.
  void measure(const ClothSystem& s, Iterate& at);
  void see_solids(const ClothSystem& s, Index n, const Double3& shift, const Double3& residual, NodeNearby& near);
  bool is_away(Index n, const Double3& shift) const;
  void start(const ClothSystem& s, const Entries<const Real3>& displacement);
  void iterate(const ClothSystem& s, bool first);
  void choose_factor(const ClothSystem& s);
  double cosine_between(const NodeVector& a, const NodeVector& b);
  int solve_linear(const ClothSystem& s);
  void make_orthogonal(int k);
  /// From `from` along change_: the next iterate.
  void move(const ClothSystem& s, const Iterate& from);
  // newton_contact.cpp
  /// Gauss-Seidel over the nodes near solids: which of their planes do they touch? (touching_: a bit of each plane.)
  void find_touching(const ClothSystem& s);
  void touch_where_pressed(const ClothSystem& s);
  void begin_zone(const ClothSystem& s);
  void relax(const ClothSystem& s, ZoneNode& z);
  /// Who sticks and who slips, and the right side of the linear system.
  void set_contact_rows(const ClothSystem& s);
  void set_row(const ClothSystem& s, Index n);
  // newton_local.cpp
  /// Where little of the cloth holds most of what is left: nonlinear Gauss-Seidel there. Changes now_.shift if it does.
  bool relax_locally(const ClothSystem& s);
  std::vector<Index> unbalanced_nodes(const ClothSystem& s) const;
  Double3 local_step(const ClothSystem& s, Index n, const Double3& residual, const NodeNearby& near) const;

  Index nodes_;
  ExactResidual exact_;
  ClothTangent tangent_;
  AndersonAcceleration anderson_;
  ChunkedSums sums_;
  Version placed_ = Version::none();  // of the nodes that the factor and the states are of
  Real dt_ = 0;
  bool warm_ = false, fresh_ = true;  // there is a factor of this time step; the solve has not begun
  SolidSight sight_;
  double goal_ = 0;                  // N
  bool late_ = false;                // what presses touches
  bool stagnates_ = false;           // the linear solve made no more progress
  bool slow_ = false;                // the residual has not halved in three iterations
  double first_length_ = 1;          // of a step that is tried
  int linear_when_new_ = 0;          // iterations of the linear solve for which the factor was made
  int excess_ = 0;                   // linear iterations of this time step that a factor of all pairs would have saved
  double cost_ = 0;                  // of a new factor, in linear iterations
  int spent_ = 0;                    // linear iterations that a new factor would have saved since
  Index changed_ = 0, toggled_ = 0;  // nodes whose free directions differ from the factor's; whose state has changed

  Iterate now_, next_, kept_;
  std::vector<Away> away_;
  std::vector<ContactState> state_;
  Vectors slip_direction_;  // of the nodes that slip
  std::vector<std::uint8_t> touching_, toggles_;
  std::vector<NodeFreedom> freedom_;
  std::vector<Matrix3> factor_free_;                       // the directions that the factor was made with
  NodeVector right_, change_, plain_, correction_, room_;  // of the linear system: N; m; m; d_c, m
  std::vector<NodeVector> directions_, images_;            // of the linear solver
  std::vector<double> products_;                           // of an image with those before it
  std::vector<ZoneNode> zone_;                             // by the tangent's groups
  std::vector<Index> zone_start_;                          // of each group
  NodeVector zone_change_, zone_step_, zone_residual_;     // m: of all sweeps, of the last one; N
};

}  // namespace drench::kokkos_backend
