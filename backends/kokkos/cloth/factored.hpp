#pragma once
// The cloth's iterations on the host: Anderson's acceleration of Projective Dynamics with its matrix factored.
// Law: docs/theory/cloth.md, section 8.

#include "cloth/pd_preconditioner.hpp"
#include "cloth/solver.hpp"

namespace drench::kokkos_backend {

/// What the iterations keep from solve to solve: the factor and arrays, none of which hands anything on.
class FactoredCloth {
 public:
  FactoredCloth(const Cloth& cloth, const ClothSystem& system);
  /// Begins a solve with these masses and this time step.
  void prepare(const Cloth& cloth, const ClothSystem& system);
  /// Iterates from solver.displacement until the residual is within its goal, at least once and `most` times at most. False
  /// where a node is at a solid: then the iterations of the other kind have to go on.
  bool run(const Cloth& cloth, ClothSolverWork& solver, const ClothSystem& system, ClothProgress& progress, int most,
           double tolerance, double floor);

 private:
  static constexpr int most_kept = 20;  // differences
  static constexpr double most_growth = 4;  // of the residual over the smallest so far

  void step(ClothSolverWork& solver);
  void keep_difference(const ClothSolverWork& solver);
  int weights(double* weight) const;

  PdPreconditioner preconditioner_;
  Field<Real3> elastic_, residual_, descent_;      // elastic forces and r, N; z, m
  Field<Real3> last_shift_, last_residual_, last_descent_;
  Field<Real3> shift_change_[most_kept], residual_change_[most_kept], descent_change_[most_kept];
  double product_[most_kept][most_kept] = {};      // ⟨Δz_i, Δr_j⟩, J
  int kept_ = 0, next_ = 0;                        // differences, and the slot of the next one
  bool has_last_ = false, elastic_known_ = false;
  // C is made at a solve's first iterate, made again where the residual grows, and done without where that did not help
  enum class Mode { none, begun, again, safe } mode_ = Mode::none;
};

}  // namespace drench::kokkos_backend
