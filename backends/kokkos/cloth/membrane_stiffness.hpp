#pragma once
// What a membrane resists with at an iterate, for the matrices of Newton's method (docs/theory/cloth.md, section 8).

#include "cloth/solver.hpp"

namespace drench::kokkos_backend {

/// A symmetric 3 × 3 matrix a I + Σ b v vᵀ.
struct Block {
  Real xx = 0, yy = 0, zz = 0, xy = 0, xz = 0, yz = 0;

  KOKKOS_INLINE_FUNCTION void add(Real a) {
    xx += a;
    yy += a;
    zz += a;
  }
  KOKKOS_INLINE_FUNCTION void add(Real b, const Real3& v) {
    xx += b * v.x * v.x;
    yy += b * v.y * v.y;
    zz += b * v.z * v.z;
    xy += b * v.x * v.y;
    xz += b * v.x * v.z;
    yz += b * v.y * v.z;
  }
  KOKKOS_INLINE_FUNCTION void add(const Block& o, Real times) {
    xx += times * o.xx;
    yy += times * o.yy;
    zz += times * o.zz;
    xy += times * o.xy;
    xz += times * o.xz;
    yz += times * o.yz;
  }
};

/// A 3 × 3 matrix Σ b v wᵀ.
struct FullBlock {
  Real3 column[3];

  KOKKOS_INLINE_FUNCTION void add(const Block& o, Real times) {
    column[0] += times * Real3{o.xx, o.xy, o.xz};
    column[1] += times * Real3{o.xy, o.yy, o.yz};
    column[2] += times * Real3{o.xz, o.yz, o.zz};
  }
  KOKKOS_INLINE_FUNCTION void add(Real b, const Real3& v, const Real3& w) {
    column[0] += (b * w.x) * v;
    column[1] += (b * w.y) * v;
    column[2] += (b * w.z) * v;
  }
  KOKKOS_INLINE_FUNCTION Real between(const Real3& v, const Real3& w) const {
    return w.x * dot(v, column[0]) + w.y * dot(v, column[1]) + w.z * dot(v, column[2]);
  }
};

/// The second derivatives of a triangle's membrane and of its strain damping, N·m, without what is negative in them.
class MembraneStiffness {
 public:
  template <class Shift>
  KOKKOS_INLINE_FUNCTION MembraneStiffness(const ClothSystem& s, Index t, const Shift& shift) : m_(s.membrane(t)) {
    const Index a = s.triangle(3 * t), b = s.triangle(3 * t + 1), c = s.triangle(3 * t + 2);
    const Real3 first = s.start(b) - s.start(a), second = s.start(c) - s.start(a);
    const Yarns<> now =
        yarns_of(first + (shift(b) - shift(a)), second + (shift(c) - shift(a)), s.triangle_shape(t), m_);
    const Yarns<> before = yarns_of(first, second, s.triangle_shape(t), m_);
    const Real rate = s.strain_damping_rate(a), wet = s.softening(t, m_);
    Real length[4], none;
    const Real3 along_u = direction_of(now.u, length[0]), along_v = direction_of(now.v, length[1]);
    along_p_ = direction_of(now.p, length[2]);
    along_q_ = direction_of(now.q, length[3]);
    before_p_ = direction_of(before.p, none);
    before_q_ = direction_of(before.q, none);
    const YarnStrains<Real> most = s.most_strains_of(t);
    of_yarn(u_, wet * m_.warp, along_u, length[0], yarn_law(length[0] - 1, m_.warp_locking, most.u), rate,
            direction_of(before.u, none));
    of_yarn(v_, wet * m_.weft, along_v, length[1], yarn_law(length[1] - 1, m_.weft_locking, most.v), rate,
            direction_of(before.v, none));
    shear_ = wet * m_.shear;
    damping_ = rate * shear_;
    // (|p| − |q|)² stiffens across the longer of both
    const Real apart = length[2] - length[3];
    if (apart > 0) across(p_, shear_ * apart / length[2], along_p_);
    if (apart < 0) across(q_, -shear_ * apart / length[3], along_q_);
  }

  /// Between corners with gradients a and b: what b's displacement does to a.
  KOKKOS_INLINE_FUNCTION FullBlock between(const CornerGradient& a, const CornerGradient& b) const {
    const InYarns i = in_yarns(a), j = in_yarns(b);
    FullBlock k;
    k.add(u_, i.u * j.u);
    k.add(v_, i.v * j.v);
    k.add(p_, i.p * j.p);
    k.add(q_, i.q * j.q);
    k.add(shear_, i.p * along_p_ - i.q * along_q_, j.p * along_p_ - j.q * along_q_);
    if (damping_ > 0) k.add(damping_, i.p * before_p_ - i.q * before_q_, j.p * before_p_ - j.q * before_q_);
    return k;
  }

 private:
  struct InYarns {
    Real u, v, p, q;
  };
  KOKKOS_INLINE_FUNCTION InYarns in_yarns(const CornerGradient& g) const {
    constexpr Real half_root = Real(0.70710678118654752);
    const Real u = m_.cosine * g.x + m_.sine * g.y, v = m_.cosine * g.y - m_.sine * g.x;
    return {u, v, half_root * (u + v), half_root * (u - v)};
  }
  /// As a spring of rest length 1 with that law.
  KOKKOS_INLINE_FUNCTION static void of_yarn(Block& k, Real stiffness, const Real3& along, Real length,
                                             const YarnLaw<Real>& law, Real rate, const Real3& before) {
    const Real taut = length > 0 ? larger(Real(0), law.tension / length) : Real(0);
    k.add(stiffness * taut);
    k.add(stiffness * (law.slope - taut), along);
    if (rate > 0) k.add(stiffness * rate, before);
  }
  KOKKOS_INLINE_FUNCTION static void across(Block& k, Real stiffness, const Real3& along) {
    k.add(stiffness);
    k.add(-stiffness, along);
  }

  Membrane<Real> m_;
  Block u_, v_, p_, q_;
  Real3 along_p_, along_q_, before_p_, before_q_;
  Real shear_ = 0, damping_ = 0;
};

}  // namespace drench::kokkos_backend
