#pragma once
// The implicit step of the cloth as a minimisation, for stage cloth and for the pressure solve that goes on with it
// (src/stages/cloth.hpp).

#include "collision.hpp"

namespace drench::reference {

/// The problem of one step; the target is the caller's to set.
struct ClothProblem {
  const ReferenceState& state;
  double dt;
  Vectors start;                 // x⁰, m
  Vectors target;                // y, m
  std::vector<double> mass;      // wet, kg
  std::vector<double> diagonal;  // D, N/m
  std::vector<PlacedBody> bodies;

  ClothProblem(const ReferenceState& state, double dt);

  const Model& model() const { return state.model; }
  const ClothMaterial& material(Index n) const { return model().cloths[model().mesh.node_cloth[n]]; }
  bool is_free(Index n) const { return !model().mesh.pinned[n]; }
  /// −∂(elastic energy)/∂x_n and the strain damping, N.
  Vectors internal_force(const Vectors& x) const;
  /// r, N.
  Vectors residual(const Vectors& x) const;
  /// Moves free nodes out of the bodies.
  void project(Vectors& x) const;
  /// The contact with the last body that the free node n touches at x; normal 0 if none.
  Contact contact(Index n, const Eigen::Vector3d& x) const;
};

/// s_n = min(1, m_f/C_n); 0 where the node holds nothing.
double node_saturation(const ReferenceState& state, Index n);
/// Where prescribed motion has brought the pinned node n at a time (s), m; where it is now if it has none.
Eigen::Vector3d pin_position(const ReferenceState& state, Index n, double time);

/// Jacobi with Chebyshev's weights, which go on over several calls of `advance`.
class ClothIteration {
 public:
  /// Begins at x = first.
  ClothIteration(const ClothProblem& problem, const Vectors& first);
  void advance(int count);
  /// Residual of the newest iterate over its goal; lowers ρ if it has grown tenfold.
  double check();
  const Vectors& x() const { return x_; }
  int iterations() const { return iterations_; }

 private:
  const ClothProblem& problem_;
  Vectors x_, previous_;
  double rho_ = 0, omega_ = 1, smallest_;
  int since_restart_ = 0, iterations_ = 0;
};

}  // namespace drench::reference
