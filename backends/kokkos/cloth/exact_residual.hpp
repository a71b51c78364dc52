#pragma once
// The residual of the cloth's implicit step in double, on a host (docs/theory/cloth.md, section 8): in single precision
// its rounding can exceed what the iterations have to resolve.

#include <vector>

#include "cloth/solver.hpp"

namespace drench::kokkos_backend {

class ExactResidual {
 public:
  explicit ExactResidual(const Cloth& cloth);
  /// r_n of the displacements `shift` (m), N; 0 at pinned nodes. Each triangle is evaluated once.
  void evaluate(const ClothSystem& s, const std::vector<Double3>& shift, std::vector<Double3>& residual);

 private:
  Index nodes_, triangles_;
  std::vector<Double3>
      corner_force_;  // on the second and the third corner of each triangle, N; the first takes the rest
};

}  // namespace drench::kokkos_backend
