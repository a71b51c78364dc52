#pragma once
// The cloth's iterations on a host: Newton's steps with a factored Hessian, and Anderson's acceleration of them.
// Law: docs/theory/cloth.md, section 8.

#include <memory>
#include <vector>

#include "cloth/cloth_hessian.hpp"
#include "cloth/differences.hpp"
#include "cloth/pd_preconditioner.hpp"
#include "cloth/solver.hpp"

namespace drench::kokkos_backend {

/// What the iterations keep from solve to solve: factors and arrays. Nothing is handed from one time step to the next.
class FactoredCloth {
 public:
  FactoredCloth(const Cloth& cloth, const ClothSystem& system);
  /// Begins a solve with these masses and this time step. Factors and differences stay as long as the nodes do.
  void prepare(const Cloth& cloth, const ClothSystem& system);
  /// Iterates from solver.displacement until the residual is within its goal, at least once and `most` times at most. False
  /// where a node is at a solid: then the iterations of the other kind have to go on.
  bool run(const Cloth& cloth, ClothSolverWork& solver, const ClothSystem& system, ClothProgress& progress, int most,
           double tolerance, double floor);

 private:
  static constexpr double most_growth = 4;  // of the residual over the smallest so far

  /// What is left of the residual over its goal (sums), and nodes within reach of a solid.
  ThreeSums measure(const Cloth& cloth, const ClothSolverWork& solver, const ClothSystem& s, double tolerance, double floor);
  /// Makes what preconditions, at this iterate.
  void factor(const Cloth& cloth, const ClothSystem& system, const Entries<const Real3>& shift);
  void make_safe(const Cloth& cloth, const ClothSystem& system);
  PdPreconditioner& projective(const Cloth& cloth, const ClothSystem& system);

  ClothHessian hessian_;
  std::unique_ptr<PdPreconditioner> projective_;  // made where it is wanted
  Differences differences_;
  Field<Real3> elastic_, residual_, descent_;  // elastic forces and r, N; z, m
  std::vector<ThreeSums> parts_;
  Version placed_ = Version::none();  // of the nodes that factors and differences are of
  Real dt_ = 0;
  bool elastic_known_ = false;
  // The matrix is made at the first iterate, made again where the residual grows, and done without where that did not help.
  enum class Mode { none, begun, again, safe } mode_ = Mode::none;
};

}  // namespace drench::kokkos_backend
