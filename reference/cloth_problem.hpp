#pragma once
// The implicit step of the cloth as a minimisation, for stage cloth and for the pressure solve that goes on with it
// (src/stages/cloth.hpp).

#include <functional>

#include "collision.hpp"

namespace drench::reference {

using Stress = Eigen::Matrix<double, 3, 2>;

/// The bodies that a node touches: the directions that they leave it, the mean velocity of their surfaces by what
/// presses, and what presses the node into all of them.
struct NodeContact {
  Eigen::Matrix3d free = Eigen::Matrix3d::Identity();
  Eigen::Vector3d surface = Eigen::Vector3d::Zero();  // m/s
  double press = 0;
  Eigen::Vector3d beside = Eigen::Vector3d::Zero();  // along `free`: normal of a body that it touches unpressed, or 0
};

/// Rest shape of a triangle in its own plane, D (m): the deformation is F = [x1 − x0, x2 − x0] D⁻¹. The first
/// axis lies along x1 − x0, the second towards x2.
Eigen::Matrix2d rest_frame(const ClothMesh& mesh, Index t);
/// Rows: ∇N of the three corners in that plane, 1/m.
Eigen::Matrix<double, 3, 2> corner_gradients(const Eigen::Matrix2d& frame);

/// The problem of one step; the target is the caller's to set.
struct ClothProblem {
  const ReferenceState& state;
  double dt;
  Vectors start;                      // x⁰, m
  Vectors target;                     // y, m
  std::vector<double> held;           // K of a soft pin that holds the node, N/m; 0 without
  std::vector<double> mass;           // wet, kg; of softly pinned nodes m + K Δt²
  std::vector<double> diagonal;       // D, N/m
  std::vector<double> stitch_length;  // at the end of the step, m
  std::vector<double> growth;         // of lengths at a node, as wet as it is, 1
  std::vector<PlacedBody> bodies;
  std::vector<Clearance> clearance;

  ClothProblem(const ReferenceState& state, const StepInfo& info);

  const Model& model() const { return state.model; }
  const ClothMaterial& material(Index n) const { return model().material_of_node(n); }
  bool is_free(Index n) const { return !model().mesh.pinned[n]; }
  /// Edges, then stitches.
  Index springs() const;
  /// rest_frame of a triangle as wet as it is.
  Eigen::Matrix2d frame(Index t) const;
  /// What the spring of edge e does to its first node, its damping with it, N. Stitches follow the edges.
  Eigen::Vector3d spring_force(Index e, const Vectors& x) const;
  /// −c_h Σ_a K_a x_a: K_a times this acts on corner a of hinge h, N.
  Eigen::Vector3d hinge_force(Index h, const Vectors& x) const;
  /// What the strain limit, −w_t A_t (F_t − F*_t), and the membrane of triangle t do: times ∇N this acts on a corner,
  /// N·m.
  Stress triangle_stress(Index t, const Vectors& x) const;
  Stress limit_stress(Index t, const Vectors& x) const;
  Stress membrane_stress(Index t, const Vectors& x) const;
  /// The strains of warp and weft up to which a triangle's yarns follow their law in this step (Eq. 4c).
  std::array<double, 2> yarn_reach(Index t) const;
  /// The sum over each node's springs, hinges and triangles of what the three functions above give, N. `triangle` is
  /// empty where no cloth has a strain limit or a membrane.
  Vectors gathered(const Vectors& spring, const Vectors& hinge, const std::vector<Stress>& triangle) const;
  /// −∂(elastic energy)/∂x_n and the strain damping, N.
  Vectors internal_force(const Vectors& x) const;
  /// r, N.
  Vectors residual(const Vectors& x) const;
  /// Moves free nodes out of the bodies.
  void project(Vectors& x) const;
  /// x, moved out of the planes that touch the bodies at their points next to `now`, to the cloth's thickness.
  Eigen::Vector3d before_planes(Index n, const Eigen::Vector3d& now, Eigen::Vector3d x) const;
  using OfBody = std::function<void(std::size_t body, const Eigen::Vector3d& pressed)>;
  /// The bodies that the free node n touches at x. `push`, a force, or a displacement of so many N per m (`stiffness`,
  /// else 1), loses what presses into them: of_body hears of each. Bodies that squeeze the node press it, too.
  NodeContact contact(Index n, const Eigen::Vector3d& x, Eigen::Vector3d& push, double stiffness,
                      const OfBody& of_body = {}) const;
  /// x after Coulomb friction of node n, which comes from `from`: it slips along the surface by `loss` (m) less, at
  /// most to a standstill. Where friction would move it into the body beside, it slips along both.
  Eigen::Vector3d with_friction(const NodeContact& contact, Index n, const Eigen::Vector3d& from, Eigen::Vector3d x,
                                double loss) const;
  /// μ, as wet as the node is.
  double friction(Index n) const;
  /// What is left of r_n after the reaction of the bodies that it touches, N.
  Eigen::Vector3d unbalanced(Index n, const Eigen::Vector3d& x, const Eigen::Vector3d& r) const;
};

/// s_n = min(1, m_f/C_n); 0 where the node holds nothing.
double node_saturation(const ReferenceState& state, Index n);
/// Where prescribed motion has brought the pinned node n at a time (s), m; where it is now if it has none.
Eigen::Vector3d pin_position(const ReferenceState& state, Index n, double time);

/// Jacobi, on positions (pd) or on multipliers (xpbd), with Chebyshev's weights, which go on over several calls of
/// `advance` until the target moves.
class ClothIteration {
 public:
  /// Begins at x = first.
  ClothIteration(const ClothProblem& problem, const Vectors& first);
  void advance(int count);
  /// Of a solve that has begun: the target has moved, and the weights start again.
  void move_on();
  /// Residual of the newest iterate over its goal; lowers ρ if it has grown tenfold.
  double check();
  /// For a solve that ended at its cap: shortens the step of each cloth that it has led uphill.
  void line_search();
  const Vectors& x() const { return x_; }
  int iterations() const { return iterations_; }

 private:
  void start();
  void gather();
  void slow_down(int before_weights);
  double residual() const;
  void iterate_positions();
  void iterate_multipliers();

  const ClothProblem& problem_;
  const ClothSolverScene solver_;
  Vectors x_, previous_;
  // of xpbd: what each spring, hinge and triangle pulls with in the last two iterates, N and N·m, and θ
  Vectors spring_, last_spring_, hinge_, last_hinge_;
  std::vector<Stress> triangle_, last_triangle_;
  std::vector<double> spring_rate_, hinge_rate_;
  std::vector<Eigen::Vector2d> triangle_rate_;  // of each column
  double rho_ = 0, omega_ = 1, smallest_, last_residual_ = 0;
  std::vector<double> checks_;  // residuals of this target
  int since_restart_ = 0, iterations_ = 0, plain_;
  int patience_ = 0;  // of xpbd: checks after which the residual must have fallen
};

}  // namespace drench::reference
