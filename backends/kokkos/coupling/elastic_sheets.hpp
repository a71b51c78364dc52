#pragma once
// The cloth inside the density solve: its implicit step goes on while the pressure changes. Law:
// src/stages/pressure.hpp.

#include "cloth/solver.hpp"
#include "coupling/sheet_response.hpp"

namespace drench::kokkos_backend {

class ElasticSheets {
 public:
  ElasticSheets(const Constants& constants, const Bodies& bodies, Cloth& cloth, ClothSolverWork& solver, Real dt);

  /// The displacement of the velocity as it is, and the target without the pressure's part. Not in the constructor:
  /// nvcc wants kernels in functions that have an address.
  void start();
  /// What node forces do to the targets.
  NodeTargets targets();
  /// Some iterations.
  void respond();
  /// The nodes' displacements in the step, m.
  const Field<Real3>& displacement() const { return solver_.displacement; }
  const ClothProgress& progress() { return iteration_.progress(); }
  /// Velocities and the pins' forces of what was found.
  void accept();

 private:
  Cloth& cloth_;
  ClothSolverWork& solver_;
  Real dt_;
  const ClothSolverScene& limits_;
  int granted_ = 0;  // iterations of this solve, at most
  ClothIteration iteration_;
};

}  // namespace drench::kokkos_backend
