#include "cloth/pd_preconditioner.hpp"

#ifndef KOKKOS_ENABLE_CUDA

#include <Eigen/SparseCholesky>
#include <algorithm>
#include <array>
#include <cmath>

#include "cloth/membrane_stiffness.hpp"

namespace drench::kokkos_backend {
namespace {

using Matrix = Eigen::SparseMatrix<double>;
using Cholesky = Eigen::SimplicialLDLT<Matrix, Eigen::Lower, Eigen::AMDOrdering<int>>;

/// The smallest half power of two that is no less than x, as its exponent, and back.
int step_of(double x) { return x > 0 ? static_cast<int>(std::ceil(2 * std::log2(x))) : -10000; }
double value_of(int step) { return step > -10000 ? std::exp2(0.5 * step) : 0; }

std::size_t at(Index i) { return static_cast<std::size_t>(i); }

/// A: constraints act along all axes alike.
struct AlongSheet {
  const ClothSystem& s;
  const std::vector<int>& step;  // PdPreconditioner::inertia_step_

  double inertia(Index, int row) const { return value_of(step[static_cast<std::size_t>(row)]); }
  double spring(Index e, Index, Index) const {
    const double damping = double(s.materials(s.edge(2 * e)).strain_damping) * value_of(step.back());
    return double(s.edge_stiffness(e)) * (1 + damping);
  }
  double aligned(Index, Index) const { return 1; }
  /// Between corners a and b of triangle t: projections hold, so a yarn weighs with what it has in the shear.
  auto membrane(Index t) const {
    const Membrane<Real> m = s.membrane(t);
    const TriangleShape shape = s.triangle_shape(t);
    const double damped = 1 + double(s.materials(s.triangle(3 * t)).strain_damping) * value_of(step.back());
    return [=](Index a, Index b) {
      const CornerGradient one = corner_gradient(shape, a), other = corner_gradient(shape, b);
      const auto along = [&](const CornerGradient& g) { return double(m.cosine) * double(g.x) + double(m.sine) * double(g.y); };
      const auto across = [&](const CornerGradient& g) { return double(m.cosine) * double(g.y) - double(m.sine) * double(g.x); };
      return damped * ((double(m.warp) + 2 * double(m.shear)) * along(one) * along(other) +
                       (double(m.weft) + 2 * double(m.shear)) * across(one) * across(other));
    };
  }
};

/// C: what the normals see of the Hessian at x⁰ + shift. A spring that is shorter than at rest resists along itself alone.
struct AcrossSheet {
  const ClothSystem& s;
  const Entries<const Real3>& shift;
  const std::vector<Real3>& normal;

  double inertia(Index n, int) const { return double(s.mass(n)) * double(s.inverse_dt2); }
  double spring(Index e, Index a, Index b) const {
    const Index i = s.edge(2 * e), j = s.edge(2 * e + 1);
    const Real3 x = separation(s.start(i), shift(i), s.start(j), shift(j));
    const double square = double(dot(x, x)), stiffness = double(s.edge_stiffness(e));
    if (!(square > 0)) return stiffness * aligned(a, b);
    const double taut = std::max(0.0, 1 - double(s.edge_length(e)) / std::sqrt(square));
    const double along = double(dot(x, normal[at(a)])) * double(dot(x, normal[at(b)])) / square;
    return stiffness * (taut * aligned(a, b) + (1 - taut + double(s.strain_damping_rate(i))) * along);
  }
  double aligned(Index a, Index b) const { return double(dot(normal[at(a)], normal[at(b)])); }
  auto membrane(Index t) const {
    return [this, t, stiffness = MembraneStiffness(s, t, shift)](Index a, Index b) {
      const TriangleShape shape = s.triangle_shape(t);
      return double(stiffness.between(corner_gradient(shape, a), corner_gradient(shape, b))
                        .between(normal[at(s.triangle(3 * t + a))], normal[at(s.triangle(3 * t + b))]));
    };
  }
};

}  // namespace

struct PdPreconditioner::Assembly {
  std::vector<int> row_of;  // of each node; −1: pinned
  std::vector<int> slot;    // where each part of the sum goes, in the order of `visit`; −1: nowhere
  Matrix matrix;            // its lower half
  Cholesky cholesky;

  /// Calls add(a, b, value) for each part of the lower half's entries, always in the same order.
  template <class Weights, class Add>
  static void visit(const Cloth& cloth, const ClothSystem& s, const std::vector<int>& row_of, const Weights& weights,
                    const Add& add);
  template <class Weights>
  void assemble(const Cloth& cloth, const ClothSystem& s, const Weights& weights);
};

template <class Weights, class Add>
void PdPreconditioner::Assembly::visit(const Cloth& cloth, const ClothSystem& s, const std::vector<int>& row_of,
                                       const Weights& weights, const Add& add) {
  for (Index n = 0; n < cloth.nodes.count; ++n)
    if (row_of[at(n)] >= 0) add(n, n, weights.inertia(n, row_of[at(n)]));
  for (Index e = 0; e < cloth.mesh.edges; ++e) {
    const Index i = s.edge(2 * e), j = s.edge(2 * e + 1);
    add(i, i, weights.spring(e, i, i));
    add(j, j, weights.spring(e, j, j));
    add(i, j, -weights.spring(e, i, j));
  }
  const Entries<const Index> hinge = cloth.mesh.hinge;
  const Entries<const Real> weight = cloth.mesh.hinge_weight, stiffness = cloth.mesh.hinge_stiffness;
  for (Index h = 0; h < cloth.mesh.hinges; ++h)
    for (Index a = 4 * h; a < 4 * h + 4; ++a)
      for (Index b = 4 * h; b <= a; ++b)
        add(hinge(a), hinge(b),
            double(stiffness(h)) * double(weight(a)) * double(weight(b)) * weights.aligned(hinge(a), hinge(b)));
  if (const Entries<const Real> plate = cloth.nodes.plate_diagonal; plate.exist())
    for (Index n = 0; n < cloth.nodes.count; ++n) {
      if (!(plate(n) > 0)) continue;
      for (Index l = s.link_start(n); l < s.link_start(n + 1); ++l) {
        const double bend = double(s.link(l).bend);
        add(n, n, -bend);
        if (s.link(l).other < n) add(n, s.link(l).other, bend * weights.aligned(n, s.link(l).other));
      }
    }
  if (s.membrane.exist())
    for (Index t = 0; t < cloth.mesh.triangles; ++t) {
      const auto between = weights.membrane(t);
      for (Index a = 0; a < 3; ++a)
        for (Index b = 0; b <= a; ++b) add(s.triangle(3 * t + a), s.triangle(3 * t + b), between(a, b));
    }
  if (!s.limit_stiffness.exist()) return;
  for (Index t = 0; t < cloth.mesh.triangles; ++t)
    for (Index a = 0; a < 3; ++a)
      for (Index b = 0; b <= a; ++b) {
        const CornerGradient one = corner_gradient(s.triangle_shape(t), a), other = corner_gradient(s.triangle_shape(t), b);
        const Index i = s.triangle(3 * t + a), j = s.triangle(3 * t + b);
        add(i, j,
            double(s.limit_stiffness(t)) * (double(one.x) * double(other.x) + double(one.y) * double(other.y)) *
                weights.aligned(i, j));
      }
}

template <class Weights>
void PdPreconditioner::Assembly::assemble(const Cloth& cloth, const ClothSystem& s, const Weights& weights) {
  double* const values = matrix.valuePtr();
  std::fill_n(values, matrix.nonZeros(), 0.0);
  std::size_t part = 0;
  visit(cloth, s, row_of, weights, [&](Index, Index, double value) {
    if (const int to = slot[part++]; to >= 0) values[to] += value;
  });
}

PdPreconditioner::PdPreconditioner(const Cloth& cloth, const ClothSystem& system)
    : assembly_(std::make_unique<Assembly>()) {
  Assembly& a = *assembly_;
  int size = 0;
  for (Index n = 0; n < cloth.nodes.count; ++n) a.row_of.push_back(system.pinned(n) ? -1 : size++);
  normal_.resize(a.row_of.size());
  if (size == 0) return;
  inertia_step_.assign(static_cast<std::size_t>(size) + 1, 0);
  const AlongSheet any{system, inertia_step_};  // any weights do: of interest is which entries there are
  std::vector<Eigen::Triplet<double, int>> parts;
  const auto entry_of = [&](Index i, Index j) {
    const int one = a.row_of[at(i)], other = a.row_of[at(j)];
    return std::array<int, 2>{std::max(one, other), std::min(one, other)};
  };
  Assembly::visit(cloth, system, a.row_of, any, [&](Index i, Index j, double) {
    const auto [row, column] = entry_of(i, j);
    if (column >= 0) parts.emplace_back(row, column, 1.0);
  });
  a.matrix.resize(size, size);
  a.matrix.setFromTriplets(parts.begin(), parts.end());
  Assembly::visit(cloth, system, a.row_of, any, [&](Index i, Index j, double) {
    const auto [row, column] = entry_of(i, j);
    if (column < 0) return a.slot.push_back(-1);
    const int* const first = a.matrix.innerIndexPtr() + a.matrix.outerIndexPtr()[column];
    const int* const last = a.matrix.innerIndexPtr() + a.matrix.outerIndexPtr()[column + 1];
    a.slot.push_back(static_cast<int>(std::lower_bound(first, last, row) - a.matrix.innerIndexPtr()));
  });
  a.cholesky.analyzePattern(a.matrix);
  inertia_step_.clear();
}

PdPreconditioner::~PdPreconditioner() = default;

void PdPreconditioner::find_normals(const Cloth& cloth, const ClothSystem& s, const Entries<const Real3>& shift) {
  std::fill(normal_.begin(), normal_.end(), Real3{});
  for (Index t = 0; t < cloth.mesh.triangles; ++t) {
    const Index a = s.triangle(3 * t), b = s.triangle(3 * t + 1), c = s.triangle(3 * t + 2);
    const Real3 twice_area = cross(separation(s.start(b), shift(b), s.start(a), shift(a)),
                                   separation(s.start(c), shift(c), s.start(a), shift(a)));
    for (const Index n : {a, b, c}) normal_[at(n)] += twice_area;
  }
  for (Real3& n : normal_) {
    const Real length = norm(n);
    n = length > 0 ? (1 / length) * n : Real3{0, 1, 0};
  }
}

void PdPreconditioner::update(const Cloth& cloth, const ClothSystem& system) {
  Assembly& a = *assembly_;
  if (a.matrix.rows() == 0) return;
  std::vector<int> step;
  step.reserve(static_cast<std::size_t>(a.matrix.rows()) + 1);
  for (Index n = 0; n < cloth.nodes.count; ++n)
    if (!system.pinned(n)) step.push_back(step_of(double(system.mass(n)) * double(system.inverse_dt2)));
  step.push_back(step_of(double(system.inverse_dt)));
  if (step == inertia_step_) return;
  inertia_step_ = std::move(step);
  a.assemble(cloth, system, AlongSheet{system, inertia_step_});
  keep_factor(0, 3);
}

void PdPreconditioner::update_across(const Cloth& cloth, const ClothSystem& system, const Entries<const Real3>& shift) {
  if (assembly_->matrix.rows() == 0) return;
  find_normals(cloth, system, shift);
  assembly_->assemble(cloth, system, AcrossSheet{system, shift, normal_});
  keep_factor(3, 4);
}

void PdPreconditioner::keep_pattern() {
  const Assembly& a = *assembly_;
  const auto& lower = a.cholesky.matrixL().nestedExpression();
  const auto& order = a.cholesky.permutationPinv().indices();
  const auto size = static_cast<std::size_t>(a.matrix.rows());
  std::vector<Index> node_of_row(size);
  for (std::size_t n = 0; n < a.row_of.size(); ++n)
    if (a.row_of[n] >= 0) node_of_row[at(a.row_of[n])] = static_cast<Index>(n);
  for (std::size_t k = 0; k < size; ++k) node_.push_back(node_of_row[at(order(static_cast<Eigen::Index>(k)))]);
  column_start_.assign(lower.outerIndexPtr(), lower.outerIndexPtr() + size + 1);
  row_.assign(lower.innerIndexPtr(), lower.innerIndexPtr() + lower.nonZeros());
  factor_.resize(row_.size());
  inverse_diagonal_.resize(size);
  solution_.resize(size);
}

void PdPreconditioner::keep_factor(int first, int last) {
  Assembly& a = *assembly_;
  a.cholesky.factorize(a.matrix);
  if (node_.empty()) keep_pattern();
  const double* const values = a.cholesky.matrixL().nestedExpression().valuePtr();
  for (int lane = first; lane < last; ++lane) {
    for (std::size_t e = 0; e < factor_.size(); ++e) factor_[e][lane] = Real(values[e]);
    for (std::size_t k = 0; k < node_.size(); ++k)
      inverse_diagonal_[k][lane] = Real(1 / a.cholesky.vectorD()(static_cast<Eigen::Index>(k)));
  }
}

void PdPreconditioner::apply(const Entries<const Real3>& r, const Entries<Real3>& z, bool safe) {
  const std::size_t size = node_.size();
  Lanes* const x = solution_.data();
  for (std::size_t k = 0; k < size; ++k) {
    const Real3 force = r(node_[k]), n = safe ? Real3{} : normal_[at(node_[k])];
    const Real across = dot(force, n);
    x[k] = Lanes{force.x - across * n.x, force.y - across * n.y, force.z - across * n.z, across};
  }
  const Index *const start = column_start_.data(), *const row = row_.data();
  const Lanes* const factor = factor_.data();
  for (std::size_t k = 0; k < size; ++k) {
    const Lanes own = x[k];
    for (Index e = start[k]; e < start[k + 1]; ++e) x[row[e]] -= factor[e] * own;
    x[k] = inverse_diagonal_[k] * own;
  }
  for (std::size_t k = size; k-- > 0;) {
    Lanes own = x[k];
    for (Index e = start[k]; e < start[k + 1]; ++e) own -= factor[e] * x[row[e]];
    x[k] = own;
    const Real3 n = safe ? Real3{} : normal_[at(node_[k])], along{own[0], own[1], own[2]};
    z(node_[k]) = along + (own[3] - dot(along, n)) * n;
  }
}

}  // namespace drench::kokkos_backend

#endif
