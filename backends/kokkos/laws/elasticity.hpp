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

/// R⁻¹ of a triangle's edges E0 = Q R at rest, 1/m: upper triangular.
struct TriangleShape {
  Real xx, xy, yy;
};

/// 1 − σ*/σ: σ (of square σ²) against the nearest stretch σ* of [1 − ε, 1 + ε].
KOKKOS_INLINE_FUNCTION Real beyond_limit(Real square, Real limit) {
  const Real stretch = Kokkos::sqrt(square);
  if (stretch > 1 + limit) return 1 - (1 + limit) / stretch;
  return stretch < 1 - limit && stretch > 0 ? 1 - (1 - limit) / stretch : Real(0);
}

/// Force on corner 0, 1 or 2 of a triangle with edges a = x1 − x0, b = x2 − x0 (m) that keeps the singular values of its
/// deformation F = [a b] R⁻¹ within [1 − ε, 1 + ε]: −∂/∂x of (K/2) |F − F*|², N; K = w A in N·m. F* = Σ_i σ*_i u_i v_iᵀ is
/// the nearest deformation within the limits; v_i are the axes of the 2 × 2 matrix FᵀF, so that F − F* = F M,
/// M = Σ_i (1 − σ*_i/σ_i) v_i v_iᵀ. A triangle without length along v_i pushes nowhere.
KOKKOS_INLINE_FUNCTION Real3 strain_limit_force(const Real3& a, const Real3& b, const TriangleShape& shape, Real limit,
                                                Real stiffness, Index corner) {
  const Real3 f1 = shape.xx * a, f2 = shape.xy * a + shape.yy * b;
  const Real p = dot(f1, f1), q = dot(f1, f2), r = dot(f2, f2);
  const Real middle = Real(0.5) * (p + r), apart = Real(0.5) * (p - r);
  const Real radius = Kokkos::sqrt(apart * apart + q * q);
  const Real most = middle + radius, least = Kokkos::fmax(Real(0), middle - radius);
  const Real up = 1 + limit, down = 1 - limit;
  if (most <= up * up && least >= down * down) return {};
  const Real beyond1 = beyond_limit(most, limit), beyond2 = beyond_limit(least, limit);
  const Real mean = Real(0.5) * (beyond1 + beyond2);
  const Real turn = radius > 0 ? Real(0.5) * (beyond1 - beyond2) / radius : Real(0);
  const Real m11 = mean + turn * apart, m12 = turn * q, m22 = mean - turn * apart;
  const Real3 g1 = m11 * f1 + m12 * f2, g2 = m12 * f1 + m22 * f2;
  const Real3 on1 = shape.xx * g1 + shape.xy * g2, on2 = shape.yy * g2;
  if (corner == 0) return stiffness * (on1 + on2);
  return -stiffness * (corner == 1 ? on1 : on2);
}

/// A corner's share of the Jacobi diagonal: half the absolute row sum of K B Bᵀ, N/m, B the corners' rows of
/// F = Bᵀ x: b1 = (xx, xy), b2 = (0, yy), b0 = −b1 − b2.
KOKKOS_INLINE_FUNCTION Real strain_limit_diagonal(const TriangleShape& s, Real stiffness, Index corner) {
  const Real x[3] = {-s.xx, s.xx, 0}, y[3] = {-s.xy - s.yy, s.xy, s.yy};
  Real sum = 0;
  for (int m = 0; m < 3; ++m) sum += Kokkos::abs(x[corner] * x[m] + y[corner] * y[m]);
  return Real(0.5) * stiffness * sum;
}

}  // namespace drench::kokkos_backend
