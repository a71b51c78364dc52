#pragma once
// The blocks of the cloth's tangent stiffness, on a host and on a GPU (docs/theory/cloth.md, section 8).

#include "cloth/limit_stiffness.hpp"
#include "cloth/membrane_stiffness.hpp"
#include "cloth/tangent_pattern.hpp"

namespace drench::kokkos_backend {

KOKKOS_INLINE_FUNCTION Matrix3 matrix(const FullBlock& k) {
  Matrix3 m;
  for (int c = 0; c < 3; ++c) m.col(c) = Column3(k.column[c].x, k.column[c].y, k.column[c].z);
  return m;
}
KOKKOS_INLINE_FUNCTION Matrix3 matrix(const Block& k) {
  Matrix3 m;
  m(0, 0) = k.xx;
  m(1, 1) = k.yy;
  m(2, 2) = k.zz;
  m(0, 1) = m(1, 0) = k.xy;
  m(0, 2) = m(2, 0) = k.xz;
  m(1, 2) = m(2, 1) = k.yz;
  return m;
}

/// What the spring of a link resists with, N/m. One that is shorter than at rest resists along itself alone.
KOKKOS_INLINE_FUNCTION Block spring_stiffness(const ClothSystem& s, Index n, const Link& l, const Real3& moved_apart) {
  Block k;
  const Real3 apart = s.start(n) - s.start(l.other), x = apart + moved_apart;
  const Real square = dot(x, x);
  if (!(square > 0) && l.length == 0) k.add(l.stiffness);  // of a stitch that is closed
  if (!(l.stiffness > 0) || !(square > 0)) return k;
  const Real taut = larger(Real(0), 1 - l.length / Kokkos::sqrt(square));
  k.add(l.stiffness * taut);
  k.add(l.stiffness * (1 - taut) / square, x);
  const Real rate = s.strain_damping_rate(n);
  if (rate > 0) k.add(strain_damping(apart, l.stiffness, rate), apart);
  return k;
}

/// The blocks of triangle t's corners and of its edges 01, 12 and 20, with the nodes moved by `shift`, m.
KOKKOS_INLINE_FUNCTION void triangle_blocks(const ClothSystem& s, Index t, const Double3* shift, Matrix3* block) {
  const auto moved = [shift](const Index n) { return narrow(shift[n]); };
  const CornerGradient b = corner_gradient(s.triangle_shape(t), 1), c = corner_gradient(s.triangle_shape(t), 2);
  LimitStiffness limit;
  Matrix3 first = Matrix3::Zero(), second = Matrix3::Zero(), both = Matrix3::Zero();
  if (s.limit_stiffness.exist() && limit_stiffness(s, t, moved, limit)) {
    first = matrix(limit.between(b, b));
    second = matrix(limit.between(c, c));
    both = matrix(limit.between(b, c));
  }
  if (s.membrane.exist()) {
    const MembraneStiffness membrane(s, t, moved);
    first += matrix(membrane.between(b, b));
    second += matrix(membrane.between(c, c));
    both += matrix(membrane.between(b, c));
  }
  // A triangle that moves as a whole does not resist, so the blocks of a row have the sum 0.
  const Matrix3 turned = both.transpose();
  block[0] = (first + second) + (both + turned);
  block[1] = first;
  block[2] = second;
  block[3] = -first - turned;
  block[4] = both;
  block[5] = -second - turned;
}

/// A node's own block, without bending.
KOKKOS_INLINE_FUNCTION Matrix3 own_block(const ClothSystem& s, Index n, const Double3* shift,
                                         const Matrix3* of_triangle) {
  Matrix3 sum = s.mass(n) * s.inverse_dt2 * Matrix3::Identity();
  for (Index l = s.link_start(n); l < s.link_start(n + 1); ++l)
    if (s.link(l).stiffness > 0)
      sum += matrix(spring_stiffness(s, n, s.link(l), narrow(shift[n] - shift[s.link(l).other])));
  if (s.triangle_start.exist())
    for (Index i = s.triangle_start(n); i < s.triangle_start(n + 1); ++i)
      sum += of_triangle[6 * (s.triangle_item(i) / 4) + s.triangle_item(i) % 4];
  return sum;
}

/// The block of an edge, row of node n, without bending. `link`: the node's; `part` to `end`: the edge's; `second`: the
/// node is the edge's second one.
KOKKOS_INLINE_FUNCTION Matrix3 edge_block(const ClothSystem& s, Index n, const Link& link, const EdgePart* part,
                                          const EdgePart* end, const Double3* shift, const Matrix3* of_triangle,
                                          bool second) {
  Matrix3 between = Matrix3::Zero();
  if (link.stiffness > 0) between -= matrix(spring_stiffness(s, n, link, narrow(shift[n] - shift[link.other])));
  for (; part != end; ++part) {
    const Matrix3& of = of_triangle[part->block];
    if (part->transposed != second)
      between += of.transpose();
    else
      between += of;
  }
  return between;
}

}  // namespace drench::kokkos_backend
