#include "cloth/pd_factor.hpp"

#ifndef KOKKOS_ENABLE_CUDA

#include <Eigen/SparseCholesky>
#include <algorithm>
#include <cmath>

#include "cloth/solver.hpp"

namespace drench::kokkos_backend {
namespace {

using Matrix = Eigen::SparseMatrix<double>;
using Triplet = Eigen::Triplet<double, int>;
using Cholesky = Eigen::SimplicialLDLT<Matrix, Eigen::Lower, Eigen::AMDOrdering<int>>;

/// The smallest half power of two that is no less than x, as its exponent, and back.
int step_of(double x) { return x > 0 ? static_cast<int>(std::ceil(2 * std::log2(x))) : -10000; }
double value_of(int step) { return step > -10000 ? std::exp2(0.5 * step) : 0; }

/// What a right-hand side has at a node, in one vector register in float.
using Lanes [[gnu::vector_size(4 * sizeof(Real))]] = Real;

}  // namespace

struct PdFactor::Assembly {
  std::vector<Index> row_of;          // of each node; −1: pinned
  std::vector<Triplet> constant;      // springs, bending, strain limits
  std::vector<Triplet> damped;        // k τ of springs with strain damping, N s/m
  Cholesky cholesky;
  Matrix matrix;
  int size = 0;

  /// Adds to A's entry of two nodes, if both are free; the lower half is kept.
  void add(std::vector<Triplet>& to, Index a, Index b, double value) const {
    const Index i = row_of[static_cast<std::size_t>(a)], j = row_of[static_cast<std::size_t>(b)];
    if (i >= 0 && j >= 0 && i >= j) to.emplace_back(i, j, value);
  }
  void add_springs(const Cloth& cloth, const ClothSystem& s);
  void add_bending(const Cloth& cloth);
  void add_limits(const Cloth& cloth, const ClothSystem& s);
};

void PdFactor::Assembly::add_springs(const Cloth& cloth, const ClothSystem& s) {
  for (Index e = 0; e < cloth.mesh.edges; ++e) {
    const Index ends[2] = {s.edge(2 * e), s.edge(2 * e + 1)};
    const double stiffness = double(s.edge_stiffness(e));
    const double time = double(s.materials(ends[0]).strain_damping);
    for (const Index a : ends)
      for (const Index b : ends) {
        const double value = a == b ? stiffness : -stiffness;
        add(constant, a, b, value);
        if (time > 0) add(damped, a, b, value * time);
      }
  }
}

void PdFactor::Assembly::add_bending(const Cloth& cloth) {
  const Entries<const Index> hinge = cloth.mesh.hinge;
  const Entries<const Real> weight = cloth.mesh.hinge_weight, stiffness = cloth.mesh.hinge_stiffness;
  for (Index h = 0; h < cloth.mesh.hinges; ++h)
    for (Index a = 0; a < 4; ++a)
      for (Index b = 0; b < 4; ++b)
        if (weight(4 * h + a) != 0 && weight(4 * h + b) != 0)
          add(constant, hinge(4 * h + a), hinge(4 * h + b),
              double(stiffness(h)) * double(weight(4 * h + a)) * double(weight(4 * h + b)));
}

void PdFactor::Assembly::add_limits(const Cloth& cloth, const ClothSystem& s) {
  if (!s.limit_start.exist()) return;
  for (Index t = 0; t < cloth.mesh.triangles; ++t) {
    const double stiffness = double(s.limit_stiffness(t));
    if (!(stiffness > 0)) continue;
    for (Index a = 0; a < 3; ++a)
      for (Index b = 0; b < 3; ++b) {
        const CornerGradient one = corner_gradient(s.triangle_shape(t), a), other = corner_gradient(s.triangle_shape(t), b);
        add(constant, s.triangle(3 * t + a), s.triangle(3 * t + b),
            stiffness * (double(one.x) * double(other.x) + double(one.y) * double(other.y)));
      }
  }
}

PdFactor::PdFactor(const Cloth& cloth, const ClothSystem& system) : assembly_(std::make_unique<Assembly>()) {
  Assembly& a = *assembly_;
  a.row_of.assign(static_cast<std::size_t>(cloth.nodes.count), -1);
  for (Index n = 0; n < cloth.nodes.count; ++n)
    if (!system.pinned(n)) a.row_of[static_cast<std::size_t>(n)] = a.size++;
  for (Index n = 0; n < cloth.nodes.count; ++n) a.add(a.constant, n, n, 0.0);
  a.add_springs(cloth, system);
  a.add_bending(cloth);
  a.add_limits(cloth, system);
}

PdFactor::~PdFactor() = default;

void PdFactor::update(const Cloth& cloth, const ClothSystem& system) {
  Assembly& a = *assembly_;
  if (a.size == 0) return;
  std::vector<int> step;
  step.reserve(static_cast<std::size_t>(a.size) + 1);
  for (Index n = 0; n < cloth.nodes.count; ++n)
    if (!system.pinned(n)) step.push_back(step_of(double(system.mass(n)) * double(system.inverse_dt2)));
  step.push_back(a.damped.empty() ? 0 : step_of(double(system.inverse_dt)));
  if (step == inertia_step_) return;
  inertia_step_ = std::move(step);

  std::vector<Triplet> all = a.constant;
  for (int k = 0; k < a.size; ++k) all.emplace_back(k, k, value_of(inertia_step_[static_cast<std::size_t>(k)]));
  const double rate = value_of(inertia_step_.back());
  for (const Triplet& t : a.damped) all.emplace_back(t.row(), t.col(), rate * t.value());
  const bool first = a.matrix.rows() == 0;
  a.matrix.resize(a.size, a.size);
  a.matrix.setFromTriplets(all.begin(), all.end());
  if (first) a.cholesky.analyzePattern(a.matrix);
  a.cholesky.factorize(a.matrix);
  keep_factor();
}

void PdFactor::keep_factor() {
  const Assembly& a = *assembly_;
  const auto& lower = a.cholesky.matrixL().nestedExpression();
  const auto& order = a.cholesky.permutationPinv().indices();
  const auto size = static_cast<std::size_t>(a.size);
  std::vector<Index> node_of_row(size);
  for (std::size_t n = 0; n < a.row_of.size(); ++n)
    if (a.row_of[n] >= 0) node_of_row[static_cast<std::size_t>(a.row_of[n])] = static_cast<Index>(n);
  node_.resize(size);
  inverse_diagonal_.resize(size);
  for (std::size_t k = 0; k < size; ++k) {
    node_[k] = node_of_row[static_cast<std::size_t>(order(static_cast<Eigen::Index>(k)))];
    inverse_diagonal_[k] = Real(1 / a.cholesky.vectorD()(static_cast<Eigen::Index>(k)));
  }
  column_start_.assign(1, 0);
  row_.clear();
  factor_.clear();
  for (int k = 0; k < a.size; ++k) {
    for (std::decay_t<decltype(lower)>::InnerIterator entry(lower, k); entry; ++entry) {
      if (entry.row() <= k) continue;
      row_.push_back(static_cast<Index>(entry.row()));
      factor_.push_back(Real(entry.value()));
    }
    column_start_.push_back(static_cast<Index>(row_.size()));
  }
}

void PdFactor::solve(const Entries<const Real3>& r, const Entries<Real3>& z) const {
  const std::size_t size = node_.size();
  thread_local std::vector<Lanes> x;
  x.resize(size);
  for (std::size_t k = 0; k < size; ++k) {
    const Real3 at = r(node_[k]);
    x[k] = Lanes{at.x, at.y, at.z, 0};
  }
  for (std::size_t k = 0; k < size; ++k) {
    const Lanes own = x[k];
    for (Index e = column_start_[k]; e < column_start_[k + 1]; ++e)
      x[static_cast<std::size_t>(row_[static_cast<std::size_t>(e)])] -= factor_[static_cast<std::size_t>(e)] * own;
    x[k] = inverse_diagonal_[k] * own;
  }
  for (std::size_t k = size; k-- > 0;) {
    Lanes own = x[k];
    for (Index e = column_start_[k]; e < column_start_[k + 1]; ++e)
      own -= factor_[static_cast<std::size_t>(e)] * x[static_cast<std::size_t>(row_[static_cast<std::size_t>(e)])];
    x[k] = own;
    z(node_[k]) = {own[0], own[1], own[2]};
  }
}

}  // namespace drench::kokkos_backend

#endif
