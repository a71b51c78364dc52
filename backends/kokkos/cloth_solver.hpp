#pragma once
// Projective Dynamics of one step by Jacobi iterations with Chebyshev acceleration: what stage cloth and the coupled
// pressure solve share. Law: src/stages/cloth.hpp. The unknown is the shift u = x − x⁰.

#include "device.hpp"
#include "laws/contact.hpp"
#include "laws/elasticity.hpp"

namespace drench::kokkos_backend {

/// What the kernels see of the cloth: everything that stays the same during one solve.
struct ClothSystem {
  Array<Real3> start, target;
  Array<Real> mass, diagonal;
  Array<std::uint8_t> pinned;
  Array<Index> cloth, edge_start, edge_item, bend_start, bend_item, edge;
  Array<Real> edge_length, edge_stiffness, bend_weight;
  Array<Index> triangle, limit_start, limit_item;
  Array<Real> limit_shape, limit_stiffness;
  Array<Material> materials;
  Array<Solid> solids;
  Real inverse_dt, inverse_dt2;

  ClothSystem(const Device& d, Real dt);

  /// −∂(elastic energy)/∂x_n and the strain damping, N.
  KOKKOS_INLINE_FUNCTION Real3 elastic_force(Index n, const Array<Real3>& shift) const {
    const Real3 here = start(n), moved = shift(n);
    const Real damping = strain_damping(n);
    Real3 force;
    for (Index r = edge_start(n); r < edge_start(n + 1); ++r) {
      const Index e = edge_item(r);
      const Index other = edge(2 * e) == n ? edge(2 * e + 1) : edge(2 * e);
      force += spring_force(separation(here, moved, start(other), shift(other)), edge_length(e), edge_stiffness(e));
      if (damping > 0)
        force += strain_damping_force(here - start(other), moved - shift(other), edge_stiffness(e), damping);
    }
    // −Σ_m B_nm x_m = −Σ_m B_nm (x_m − x_n): the rows of B sum to 0
    for (Index r = bend_start(n); r < bend_start(n + 1); ++r) {
      const Index other = bend_item(r);
      force -= bend_weight(r) * separation(start(other), shift(other), here, moved);
    }
    if (limit_start.extent(0) > 0) force += limit_force(n, shift);
    return force;
  }

  /// Strain limiting, N.
  KOKKOS_INLINE_FUNCTION Real3 limit_force(Index n, const Array<Real3>& shift) const {
    const Real limit = materials(cloth(n)).strain_limit;
    Real3 force;
    for (Index r = limit_start(n); r < limit_start(n + 1); ++r) {
      const Index t = limit_item(r) / 4, a = triangle(3 * t), b = triangle(3 * t + 1), c = triangle(3 * t + 2);
      force += strain_limit_force(separation(start(b), shift(b), start(a), shift(a)),
                                  separation(start(c), shift(c), start(a), shift(a)), triangle_shape(t), limit,
                                  limit_stiffness(t), limit_item(r) % 4);
    }
    return force;
  }
  KOKKOS_INLINE_FUNCTION TriangleShape triangle_shape(Index t) const {
    return {limit_shape(3 * t), limit_shape(3 * t + 1), limit_shape(3 * t + 2)};
  }

  /// r_n, N.
  KOKKOS_INLINE_FUNCTION Real3 residual(Index n, const Array<Real3>& shift) const {
    return (mass(n) * inverse_dt2) * (target(n) - shift(n)) + elastic_force(n, shift);
  }

  /// τ/Δt of the node's cloth.
  KOKKOS_INLINE_FUNCTION Real strain_damping(Index n) const { return materials(cloth(n)).strain_damping * inverse_dt; }
  KOKKOS_INLINE_FUNCTION Real thickness(Index n) const { return materials(cloth(n)).thickness; }
};

/// Chebyshev's weights (Wang 2015), which go on over several calls of `advance`.
class ClothIteration {
 public:
  /// Wet masses and Jacobi diagonals; the caller sets target and shift afterwards.
  ClothIteration(Device& d, Real dt);
  const ClothSystem& system() const { return system_; }
  int iterations() const { return iterations_; }
  /// `count` iterations; the newest iterate is d.cloth_work.shift.
  void advance(int count);
  /// The residual of the newest iterate in units of its goal: converged if ≤ 1. If it has grown tenfold over the
  /// smallest so far, ρ is lowered and the weights start again. Synchronises with the host.
  double check();

 private:
  Device& device_;
  ClothSystem system_;
  double rho_, omega_ = 1, smallest_ = 1e300;
  int since_restart_ = 0, iterations_ = 0;
};

}  // namespace drench::kokkos_backend
