#pragma once
// The cloth's system in the memory of a GPU's host.

#include <any>
#include <vector>

#include "cloth/solver.hpp"

namespace drench::kokkos_backend {

/// A copy of all that a ClothSystem points to, and of the displacements, as they are now. Waits. Distances of bodies
/// are copied once and stay in ClothSolverWork::fields_on_host.
class HostCloth {
 public:
  HostCloth(const Bodies& bodies, const Cloth& cloth, ClothSolverWork& solver, const ClothSystem& s);
  /// The solver's displacements become those here.
  void write_displacement(ClothSolverWork& solver) const;

  ClothSystem system;  // without what Jacobi iterations alone read
  Entries<Real3> displacement;

 private:
  template <class T>
  Entries<T> copy(const Field<T>& a);
  Slice<const Solid> copy_solids(const Bodies& bodies, ClothSolverWork& solver);

  std::vector<std::any> kept_;  // the copies
};

}  // namespace drench::kokkos_backend
