#pragma once
// Elastic forces of the cloth, gathered per node. Differences of positions are formed from the start position x⁰ and
// the shift u = x − x⁰ apart: with floats, a solve in u keeps the digits that x itself has no room for.

#include "core/types.hpp"
#include "state/model.hpp"

namespace drench::kokkos_backend {

/// x_i − x_j = (x⁰_i − x⁰_j) + (u_i − u_j), m, in the precision of the shifts.
template <class T>
KOKKOS_INLINE_FUNCTION Vector3<T> separation(const Real3& start_i, const Vector3<T>& shift_i, const Real3& start_j,
                                             const Vector3<T>& shift_j) {
  return (in_precision<T>(start_i) - in_precision<T>(start_j)) + (shift_i - shift_j);
}

/// Differences of nearly equal numbers have few digits in float, and their rounding would be forces that no iteration
/// balances. In double they have enough.
template <class T>
constexpr bool enough_digits = std::is_same_v<T, double>;

/// |x⁰_ij|² − L² of an edge at the start of the step, m², computed in double; 0 where digits are enough without it.
template <class T>
KOKKOS_INLINE_FUNCTION T spring_excess(const Real3& start_i, const Real3& start_j, Real rest_length) {
  if constexpr (enough_digits<T>) return 0;
  const Double3 apart = widen(start_i) - widen(start_j);
  return T(dot(apart, apart) - double(rest_length) * double(rest_length));
}
/// −k (1 − L/|x_ij|), N/m: times x_ij it is the force on node i of an edge spring (Liu et al. 2013), −k (x_ij − L
/// x_ij/|x_ij|); x_ij = x⁰_ij + u_ij in m, `excess` = spring_excess, rest length L in m, k in N/m. |x|² − L² follows
/// from that at x⁰. Coincident ends: d_e = 0.
template <class T>
KOKKOS_INLINE_FUNCTION T spring_pull(const Vector3<T>& start_ij, const std::type_identity_t<Vector3<T>>& u_ij,
                                     std::type_identity_t<T> excess, Real rest_length, Real stiffness) {
  const Vector3<T> x_ij = start_ij + u_ij;
  const T square = fused_square(x_ij);
  if (!(square > 0)) return 0;
  if constexpr (enough_digits<T>) return -stiffness * (1 - rest_length * inverse_root(square));
  const Vector3<T> sum = start_ij + x_ij;  // |x|² − |x⁰|² = (x⁰ + x)·u
  const T inverse = inverse_root(square),
          beyond = fused(sum.z, u_ij.z, fused(sum.y, u_ij.y, fused(sum.x, u_ij.x, excess)));
  return quotient(-stiffness * inverse * beyond, square * inverse + T(rest_length));
}

/// What strain_damping_force needs of an edge, N/m³: k τ/Δt/|x⁰_ij|²; `start_ij` = x⁰_ij in m, `rate` = τ/Δt.
KOKKOS_INLINE_FUNCTION Real strain_damping(const Real3& start_ij, Real stiffness, Real rate) {
  const Real square = dot(start_ij, start_ij);
  return square > 0 ? stiffness * rate / square : Real(0);
}

/// Force on node i of an edge that resists stretching at a rate (Kelvin–Voigt), implicit in the shift:
/// −k τ/Δt e (e·u_ij), N; e = direction of the edge at x⁰, u_ij = u_i − u_j in m.
template <class T>
KOKKOS_INLINE_FUNCTION Vector3<T> strain_damping_force(const Vector3<T>& start_ij,
                                                       const std::type_identity_t<Vector3<T>>& u_ij, Real damping) {
  return (-damping * dot(start_ij, u_ij)) * start_ij;
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
template <class T>
KOKKOS_INLINE_FUNCTION T beyond_limit(T square, Real limit) {
  const T stretch = Kokkos::sqrt(square);
  if (stretch > 1 + limit) return 1 - (1 + limit) / stretch;
  return stretch < 1 - limit && stretch > 0 ? 1 - (1 - limit) / stretch : T(0);
}

/// A 3 × 2 matrix by its columns.
template <class T = Real>
struct Columns {
  Vector3<T> first, second;
};

/// P = −K (F − F*) = −K F M, N·m, of a triangle with edges a = x1 − x0, b = x2 − x0 (m): it keeps the singular values
/// σ_i of F = [a b] R⁻¹ within [1 − ε, 1 + ε]. M = Σ_i (1 − σ*_i/σ_i) v_i v_iᵀ with the axes v_i of FᵀF and the limited
/// σ*_i; K = w A. A triangle without length along v_i pushes nowhere. (docs/theory/cloth.md, section 5.)
template <class T>
KOKKOS_INLINE_FUNCTION Columns<T> strain_limit_stress(const Vector3<T>& a, const Vector3<T>& b,
                                                      const TriangleShape& shape, Real limit, Real stiffness) {
  const Vector3<T> f1 = shape.xx * a, f2 = shape.xy * a + shape.yy * b;
  const T p = dot(f1, f1), q = dot(f1, f2), r = dot(f2, f2);
  const T middle = T(0.5) * (p + r), apart = T(0.5) * (p - r);
  const T radius = Kokkos::sqrt(apart * apart + q * q);
  const T most = middle + radius, least = larger(T(0), middle - radius);
  const Real up = 1 + limit, down = 1 - limit;
  if (most <= up * up && least >= down * down) return {};
  const T beyond1 = beyond_limit(most, limit), beyond2 = beyond_limit(least, limit);
  const T mean = T(0.5) * (beyond1 + beyond2);
  const T turn = radius > 0 ? T(0.5) * (beyond1 - beyond2) / radius : T(0);
  const T m11 = mean + turn * apart, m12 = turn * q, m22 = mean - turn * apart;
  return {-stiffness * (m11 * f1 + m12 * f2), -stiffness * (m12 * f1 + m22 * f2)};
}

/// A yarn that locks at the strain `lock` (0: never), at the strain e: T = k e/(1 − (e/lock)²) for e > 0, beyond
/// `most` along its tangent there; over k. (docs/theory/cloth.md, Eq. 4c.)
template <class T>
struct YarnLaw {
  T tension, slope;
};
template <class T>
KOKKOS_INLINE_FUNCTION YarnLaw<T> yarn_law(T e, std::type_identity_t<T> lock, std::type_identity_t<T> most) {
  if (!(lock > 0 && e > 0)) return {e, 1};
  const T at = smaller(e, most), part = (at / lock) * (at / lock), inverse = 1 / (1 - part);
  const T slope = (1 + part) * inverse * inverse;
  return {at * inverse + slope * (e - at), slope};
}
/// The strains up to which the yarns of a triangle follow their law in a step: a little beyond those that it begins
/// with.
template <class T>
struct YarnStrains {
  T u = 0, v = 0;
};
KOKKOS_INLINE_FUNCTION bool yarns_lock(const Membrane<Real>& m) { return m.warp_locking > 0 || m.weft_locking > 0; }

/// K of a membrane's share of the Jacobi diagonal, N·m: it bounds the second derivative by both columns of F.
KOKKOS_INLINE_FUNCTION Real membrane_bound(const Membrane<Real>& m, const YarnStrains<Real>& most) {
  const Real warp = m.warp * yarn_law(most.u, m.warp_locking, most.u).slope;
  const Real weft = m.weft * yarn_law(most.v, m.weft_locking, most.v).slope;
  return larger(warp, weft) + 2 * m.shear;
}

/// How a triangle is stretched along its warp u and weft v and along the lines p, q halfway between them: F of these
/// directions.
template <class T = Real>
struct Yarns {
  Vector3<T> u, v, p, q;
};
template <class T>
KOKKOS_INLINE_FUNCTION Yarns<T> yarns_of(const Vector3<T>& a, const std::type_identity_t<Vector3<T>>& b,
                                         const TriangleShape& shape, const Membrane<Real>& m) {
  constexpr T half_root = T(0.70710678118654752);
  const Vector3<T> f1 = shape.xx * a, f2 = shape.xy * a + shape.yy * b;
  const Vector3<T> u = m.cosine * f1 + m.sine * f2, v = m.cosine * f2 - m.sine * f1;
  return {u, v, half_root * (u + v), half_root * (u - v)};
}
/// |u|² − 1, |v|² − 1 and u·v of these directions, which differ little from 0.
template <class T = Real>
struct YarnExcess {
  T u = 0, v = 0, both = 0;
};
/// Of a triangle with these edges (m), computed in double; 0 where digits are enough without it.
template <class T>
KOKKOS_INLINE_FUNCTION YarnExcess<T> yarn_excess(const Double3& first, const Double3& second,
                                                 const TriangleShape& shape, const Membrane<Real>& m) {
  if constexpr (enough_digits<T>) return {};
  const Yarns<double> y = yarns_of(first, second, shape, m);
  return {T(dot(y.u, y.u) - 1), T(dot(y.v, y.v) - 1), T(dot(y.u, y.v))};
}
/// v/|v|, or 0; |v| in `length`.
template <class T>
KOKKOS_INLINE_FUNCTION Vector3<T> direction_of(const Vector3<T>& v, T& length) {
  const T square = dot(v, v), inverse = square > 0 ? inverse_root(square) : T(0);
  length = square * inverse;
  return inverse * v;
}

/// YarnStrains of the triangle with these edges at the start of the step (m), computed in double.
template <class T>
KOKKOS_INLINE_FUNCTION YarnStrains<T> most_strains(const Double3& first, const Double3& second,
                                                   const TriangleShape& shape, const Membrane<Real>& m) {
  const Yarns<double> y = yarns_of(first, second, shape, m);
  const auto most = [](const Double3& yarn, Real lock) {
    return T(smaller(locking_part * double(lock), larger(0.0, norm(yarn) - 1) + locking_margin));
  };
  return {most(y.u, m.warp_locking), most(y.v, m.weft_locking)};
}

/// P = −A ∂W/∂F, N·m, of a membrane with W = ½ k_u (|u| − 1)² + ½ k_v (|v| − 1)² +
/// ½ k_s (|p| − |q|)², of yarns that lock and follow their law up to the strains `most`, and of its
/// strain damping, implicit in the shift; at x, at x⁰, and of the shift u alone; rate = t_d/Δt. Strains follow from
/// those at x⁰ (`excess`): |u| − 1 = (|u|² − 1)/(|u| + 1) and |p| − |q| = 2 u·v/(|p| + |q|). (docs/theory/cloth.md,
/// sections 2, 4.)
template <class T>
KOKKOS_INLINE_FUNCTION Columns<T> membrane_stress(const Yarns<T>& now, const Yarns<T>& before, const Yarns<T>& moved,
                                                  const YarnExcess<T>& excess, const YarnStrains<T>& most,
                                                  const Membrane<Real>& m, Real rate, Real wet) {
  constexpr T half_root = T(0.70710678118654752);
  T u, v, p, q;
  const Vector3<T> along_u = direction_of(now.u, u), along_v = direction_of(now.v, v);
  const Vector3<T> along_p = direction_of(now.p, p), along_q = direction_of(now.q, q);
  T strain_u = u - 1, strain_v = v - 1, sheared = p - q;
  if constexpr (!enough_digits<T>) {
    strain_u = quotient(excess.u + dot(before.u + now.u, moved.u), u + 1);
    strain_v = quotient(excess.v + dot(before.v + now.v, moved.v), v + 1);
    const T both = excess.both + dot(before.u, moved.v) + dot(moved.u, now.v);
    sheared = p + q > 0 ? quotient(2 * both, p + q) : T(0);
  }
  if (yarns_lock(m)) {
    strain_u = yarn_law<T>(strain_u, m.warp_locking, most.u).tension;
    strain_v = yarn_law<T>(strain_v, m.weft_locking, most.v).tension;
  }
  Vector3<T> of_u = (-m.warp * strain_u) * along_u, of_v = (-m.weft * strain_v) * along_v;
  Vector3<T> of_p = (-m.shear * sheared) * along_p, of_q = (m.shear * sheared) * along_q;
  if (rate > 0) {
    const Vector3<T> u0 = direction_of(before.u, u), v0 = direction_of(before.v, v);
    const Vector3<T> p0 = direction_of(before.p, p), q0 = direction_of(before.q, q);
    of_u -= (m.warp * rate * dot(u0, moved.u)) * u0;
    of_v -= (m.weft * rate * dot(v0, moved.v)) * v0;
    const T shearing = dot(p0, moved.p) - dot(q0, moved.q);
    of_p -= (m.shear * rate * shearing) * p0;
    of_q += (m.shear * rate * shearing) * q0;
  }
  of_u = wet * (of_u + half_root * (of_p + of_q));
  of_v = wet * (of_v + half_root * (of_p - of_q));
  return {m.cosine * of_u - m.sine * of_v, m.sine * of_u + m.cosine * of_v};
}

/// ∇N of a corner in the triangle's own plane, 1/m: its row of F = Σ_c x_c (∇N_c)ᵀ.
struct CornerGradient {
  Real x, y;
};
KOKKOS_INLINE_FUNCTION CornerGradient corner_gradient(const TriangleShape& s, Index corner) {
  if (corner == 1) return {s.xx, s.xy};
  if (corner == 2) return {0, s.yy};
  return {-s.xx, -s.xy - s.yy};
}

/// Force of a stress P on a corner: P ∇N, N.
template <class T>
KOKKOS_INLINE_FUNCTION Vector3<T> corner_force(const Columns<T>& stress, const CornerGradient& n) {
  return n.x * stress.first + n.y * stress.second;
}

/// Σ_a |∂_x N_a| and Σ_a |∂_y N_a|, 1/m.
KOKKOS_INLINE_FUNCTION CornerGradient gradient_sums(const TriangleShape& s) {
  CornerGradient sum{0, 0};
  for (Index c = 0; c < 3; ++c) {
    const CornerGradient n = corner_gradient(s, c);
    sum.x += Kokkos::abs(n.x);
    sum.y += Kokkos::abs(n.y);
  }
  return sum;
}

/// A corner's share of the Jacobi diagonal: ½ K Σ_c |∂_c N_n| Σ_a |∂_c N_a|, N/m, a column c of F a constraint.
KOKKOS_INLINE_FUNCTION Real triangle_diagonal(const TriangleShape& s, Real stiffness, Index corner) {
  const CornerGradient own = corner_gradient(s, corner), sum = gradient_sums(s);
  return Real(0.5) * stiffness * (Kokkos::abs(own.x) * sum.x + Kokkos::abs(own.y) * sum.y);
}

}  // namespace drench::kokkos_backend
