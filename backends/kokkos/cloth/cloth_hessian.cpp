#include "cloth/cloth_hessian.hpp"

#ifndef KOKKOS_ENABLE_CUDA

#include <algorithm>

#include "cloth/limit_stiffness.hpp"

namespace drench::kokkos_backend {
namespace {

std::size_t at(Index i) { return static_cast<std::size_t>(i); }

std::vector<Index> free_nodes(const Cloth& cloth) {
  std::vector<Index> nodes;
  for (Index n = 0; n < cloth.nodes.count; ++n)
    if (!cloth.nodes.pinned(at(n))) nodes.push_back(n);
  return nodes;
}

std::vector<Index> rows_of(const std::vector<Index>& free, Index nodes) {
  std::vector<Index> row(at(nodes), -1);
  for (std::size_t k = 0; k < free.size(); ++k) row[at(free[k])] = static_cast<Index>(k);
  return row;
}

/// The free nodes that share a link.
std::vector<std::vector<Index>> pattern_of(const ClothSystem& s, const std::vector<Index>& free,
                                           const std::vector<Index>& row_of) {
  std::vector<std::vector<Index>> near(free.size());
  for (std::size_t k = 0; k < free.size(); ++k)
    for (Index l = s.link_start(free[k]); l < s.link_start(free[k] + 1); ++l)
      if (const Index other = row_of[at(s.link(l).other)]; other >= 0) near[k].push_back(other);
  return near;
}

/// What a link resists with, N/m. A spring that is shorter than at rest resists along itself alone.
Block stiffness(const ClothSystem& s, Index n, const Link& l, const Entries<const Real3>& shift, Real rate) {
  Block k;
  k.add(-l.bend);
  const Real3 apart = s.start(n) - s.start(l.other), x = apart + (shift(n) - shift(l.other));
  const Real square = dot(x, x);
  if (!(l.stiffness > 0) || !(square > 0)) return k;
  const Real taut = Kokkos::fmax(Real(0), 1 - l.length / Kokkos::sqrt(square));
  k.add(l.stiffness * taut);
  k.add(l.stiffness * (1 - taut) / square, x);
  if (rate > 0) k.add(strain_damping(apart, l.stiffness, rate), apart);
  return k;
}

}  // namespace

ClothHessian::ClothHessian(const Cloth& cloth, const ClothSystem& s, double most_work)
    : free_(free_nodes(cloth)), row_of_(rows_of(free_, cloth.nodes.count)), factor_(pattern_of(s, free_, row_of_)) {
  if (factor_.work() > most_work) return;
  factor_.make_room();
  solution_.resize(3 * free_.size());
  for (Index n = 0; n < cloth.nodes.count; ++n) {
    own_.push_back(target(n, n));
    for (Index l = s.link_start(n); l < s.link_start(n + 1); ++l) shared_.push_back(target(n, s.link(l).other));
    if (!s.triangle_start.exist()) continue;
    for (Index r = s.triangle_start(n); r < s.triangle_start(n + 1); ++r)
      for (Index c = 0; c < 3; ++c) of_triangle_.push_back(target(n, s.triangle(3 * (s.triangle_item(r) / 4) + c)));
  }
}

ClothHessian::Target ClothHessian::target(Index row, Index column) const {
  const Index i = row_of_[at(row)], j = row_of_[at(column)];
  if (i < 0 || j < 0 || !factor_.is_below(i, j)) return {};
  const BlockCholesky::Place place = factor_.block(i, j);
  return {static_cast<std::uint32_t>(place.at), place.stride};
}

void ClothHessian::update(const Cloth& cloth, const ClothSystem& s, const Entries<const Real3>& shift) {
  factor_.clear();
  Real* const values = factor_.values();
  const Target *const own = own_.data(), *const shared = shared_.data(), *const of_triangle = of_triangle_.data();
  parallel("drench::cloth::hessian", cloth.nodes.count, [=](const Index n) {
    if (own[n].stride == 0) return;
    const Real rate = s.strain_damping_rate(n);
    Block diagonal;
    diagonal.add(s.mass(n) * s.inverse_dt2);
    for (Index l = s.link_start(n); l < s.link_start(n + 1); ++l) {
      const Block k = stiffness(s, n, s.link(l), shift, rate);
      diagonal.add(k, 1);
      Block less;
      less.add(k, -1);
      if (shared[l].stride > 0) less.add_to(values + shared[l].at, shared[l].stride);
    }
    if (s.triangle_start.exist())
      for (Index r = s.triangle_start(n); r < s.triangle_start(n + 1); ++r) {
        const Index t = s.triangle_item(r) / 4;
        const CornerGradient here = corner_gradient(s.triangle_shape(t), s.triangle_item(r) % 4);
        LimitStiffness limit;
        if (s.limit_stiffness.exist() && limit_stiffness(s, t, shift, limit))
          for (Index c = 0; c < 3; ++c)
            if (const Target to = of_triangle[3 * r + c]; to.stride > 0)
              limit.between(here, corner_gradient(s.triangle_shape(t), c)).add_to(values + to.at, to.stride);
        if (!s.membrane.exist()) continue;
        const MembraneStiffness membrane(s, t, shift);
        for (Index c = 0; c < 3; ++c)
          if (const Target to = of_triangle[3 * r + c]; to.stride > 0)
            membrane.between(here, corner_gradient(s.triangle_shape(t), c)).add_to(values + to.at, to.stride);
      }
    diagonal.add_to(values + own[n].at, own[n].stride);
  });
  factor_.factor();
}

void ClothHessian::apply(const Entries<const Real3>& r, const Entries<Real3>& z) {
  for (std::size_t k = 0; k < free_.size(); ++k) {
    const Real3 force = r(free_[k]);
    Real* const x = solution_.data() + 3 * at(factor_.place(static_cast<Index>(k)));
    x[0] = force.x;
    x[1] = force.y;
    x[2] = force.z;
  }
  factor_.solve(solution_.data());
  for (std::size_t k = 0; k < free_.size(); ++k) {
    const Real* const x = solution_.data() + 3 * at(factor_.place(static_cast<Index>(k)));
    z(free_[k]) = {x[0], x[1], x[2]};
  }
}

}  // namespace drench::kokkos_backend

#endif
