#pragma once
// Elastic forces of the cloth, gathered per node. Differences of positions are formed from the start position x⁰ and
// the shift u = x − x⁰ apart: with floats, a solve in u keeps the digits that x itself has no room for.

#include "types.hpp"

namespace drench::kokkos_backend {

/// x_i − x_j = (x⁰_i − x⁰_j) + (u_i − u_j), m.
KOKKOS_INLINE_FUNCTION Real3 separation(const Real3& start_i, const Real3& shift_i, const Real3& start_j,
                                        const Real3& shift_j) {
  return (start_i - start_j) + (shift_i - shift_j);
}

/// Force on node i of an edge spring (Liu et al. 2013): −k (x_ij − L x_ij/|x_ij|), N;
/// x_ij = x_i − x_j in m, rest length L in m, k in N/m. Coincident ends: d_e = 0.
KOKKOS_INLINE_FUNCTION Real3 spring_force(const Real3& x_ij, Real rest_length, Real stiffness) {
  const Real length = norm(x_ij);
  return length > 0 ? (-stiffness * (1 - rest_length / length)) * x_ij : Real3{};
}

/// Force on node i of an edge that resists stretching at a rate (Kelvin–Voigt), implicit in the shift:
/// −k τ/Δt e (e·u_ij), N; e = direction of the edge at x⁰, u_ij = u_i − u_j in m, `rate` = τ/Δt.
KOKKOS_INLINE_FUNCTION Real3 strain_damping_force(const Real3& start_ij, const Real3& u_ij, Real stiffness, Real rate) {
  const Real square = dot(start_ij, start_ij);
  return square > 0 ? (-stiffness * rate * dot(start_ij, u_ij) / square) * start_ij : Real3{};
}

/// Force on a corner of a hinge (quadratic bending, Bergou et al. 2006): −c K_n Σ_a K_a x_a, N;
/// bend = Σ_a K_a x_a in m, c in N/m, K_n of unit 1.
KOKKOS_INLINE_FUNCTION Real3 hinge_force(const Real3& bend, Real weight, Real stiffness) {
  return (-stiffness * weight) * bend;
}

/// A corner's share of the Jacobi diagonal: half the absolute row sum, ½ c |K_n| Σ_a |K_a|, N/m
/// (Wang 2015 needs D no smaller).
KOKKOS_INLINE_FUNCTION Real hinge_diagonal(Real weight, Real weight_sum, Real stiffness) {
  return Real(0.5) * stiffness * Kokkos::abs(weight) * weight_sum;
}

}  // namespace drench::kokkos_backend
