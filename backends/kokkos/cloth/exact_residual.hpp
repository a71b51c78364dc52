#pragma once
// The residual of the cloth's implicit step in double, on a host (docs/theory/cloth.md, section 8): in single precision
// its rounding can exceed what the iterations have to resolve.

#include <vector>

#include "cloth/solver.hpp"

namespace drench::kokkos_backend {

class ExactResidual {
 public:
  ExactResidual(const Cloth& cloth, const ClothSystem& s);
  /// The nodes begin a step: what bends is linear in them, and its part of x⁰ stays the same.
  void begin_step(const ClothSystem& s);
  /// −∂(elastic energy)/∂x_n and strain damping at the displacements `shift` (m), N; 0 at pinned nodes. Each triangle
  /// is evaluated once.
  void evaluate_elastic(const ClothSystem& s, const std::vector<Double3>& shift, std::vector<Double3>& elastic);
  /// r_n, N, of the elastic forces at `shift`; 0 at pinned nodes.
  void add_inertia(const ClothSystem& s, const std::vector<Double3>& shift, const std::vector<Double3>& elastic,
                   std::vector<Double3>& residual) const;

 private:
  struct BendingLink {
    Index other;
    Real bend;  // N/m
  };
  /// −Σ_m B_nm v_m, N, of a vector per node, m.
  template <class Vector>
  Double3 bending_force(Index n, const Vector& v) const {
    const Double3 here = v(n);
    Double3 force;
    for (Index b = bending_start_[at(n)]; b < bending_start_[at(n + 1)]; ++b)
      force += double(bending_[at(b)].bend) * (here - v(bending_[at(b)].other));
    return force;
  }

  Index nodes_, triangles_;
  std::vector<Double3>
      corner_force_;  // on the second and the third corner of each triangle, N; the first takes the rest
  std::vector<Index> bending_start_, spring_start_;  // of each node
  std::vector<BendingLink> bending_;
  std::vector<Index> springs_;          // numbers of links: stitches shorten
  std::vector<Double3> bending_at_x0_;  // of each node, N
};

}  // namespace drench::kokkos_backend
