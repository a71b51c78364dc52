#pragma once
// Vectors with three numbers per node of the cloth, on a host, and sums over them that do not depend on the number of
// threads.

#include <Eigen/Core>
#include <algorithm>
#include <vector>

#include "core/host_parallel.hpp"

namespace drench::kokkos_backend {

using Matrix3 = Eigen::Matrix<Real, 3, 3>;
using Column3 = Eigen::Matrix<Real, 3, 1>;
/// Three numbers per node.
using NodeVector = std::vector<Real>;

inline Eigen::Map<Column3> at_node(NodeVector& v, Index n) { return Eigen::Map<Column3>(v.data() + 3 * n); }
inline Eigen::Map<const Column3> at_node(const NodeVector& v, Index n) {
  return Eigen::Map<const Column3>(v.data() + 3 * n);
}
KOKKOS_INLINE_FUNCTION Column3 column(const Double3& v) { return {Real(v.x), Real(v.y), Real(v.z)}; }
KOKKOS_INLINE_FUNCTION Double3 in_double(const Column3& v) { return {double(v[0]), double(v[1]), double(v[2])}; }

/// Loops over all numbers of a vector go by chunks of so many.
inline constexpr Index numbers_per_chunk = 192;
/// Calls part(begin, end) for chunks of [0, count), which threads share.
template <class Part>
void for_chunks(const char* label, Index count, const Part& part) {
  host_parallel(label, (count + numbers_per_chunk - 1) / numbers_per_chunk,
                [&](const Index p) { part(p * numbers_per_chunk, std::min(count, (p + 1) * numbers_per_chunk)); });
}

/// Sums of nodes in chunks of fixed length, which are added one after the other.
class ChunkedSums {
 public:
  /// Σ term(n) over [0, nodes).
  template <class Term>
  double operator()(const char* label, Index nodes, const Term& term) {
    const Index chunks = (nodes + length - 1) / length;
    parts_.resize(static_cast<std::size_t>(chunks));
    double* const part = parts_.data();
    host_parallel(label, chunks, [=, &term](const Index p) {
      double sum = 0;
      for (Index n = p * length; n < std::min(nodes, (p + 1) * length); ++n) sum += term(n);
      part[p] = sum;
    });
    double sum = 0;
    for (const double p : parts_) sum += p;
    return sum;
  }
  /// a · b.
  double dot(const NodeVector& a, const NodeVector& b) {
    return (*this)("drench::cloth::node_dot", static_cast<Index>(a.size() / 3), [&](const Index n) {
      const auto i = 3 * static_cast<std::size_t>(n);
      return double(a[i]) * double(b[i]) + double(a[i + 1]) * double(b[i + 1]) + double(a[i + 2]) * double(b[i + 2]);
    });
  }
  /// a_j · b for the first `count` vectors a_j; all of them in one loop.
  void dots(const std::vector<NodeVector>& a, int count, const NodeVector& b, std::vector<double>& product) {
    const auto numbers = static_cast<Index>(b.size());
    const auto each = static_cast<std::size_t>(count);
    parts_.resize(static_cast<std::size_t>((numbers + numbers_per_chunk - 1) / numbers_per_chunk) * each);
    double* const part = parts_.data();
    for_chunks("drench::cloth::node_dots", numbers, [=, &a, &b](const Index begin, const Index end) {
      const Real* const y = b.data();
      for (std::size_t j = 0; j < each; ++j) {
        const Real* const x = a[j].data();
        double sum = 0;
        for (Index i = begin; i < end; ++i) sum += double(x[i]) * double(y[i]);
        part[static_cast<std::size_t>(begin / numbers_per_chunk) * each + j] = sum;
      }
    });
    product.assign(each, 0);
    for (std::size_t k = 0; k < parts_.size(); ++k) product[k % each] += parts_[k];
  }
  /// Σ |r_n|.
  double norms(const NodeVector& r) {
    return (*this)("drench::cloth::node_norms", static_cast<Index>(r.size() / 3),
                   [&](const Index n) { return double(at_node(r, n).norm()); });
  }

 private:
  static constexpr Index length = 64;
  std::vector<double> parts_;
};

/// y += a x.
inline void add_scaled(const char* label, Real a, const NodeVector& x, NodeVector& y) {
  const Real* const from = x.data();
  Real* const to = y.data();
  for_chunks(label, static_cast<Index>(y.size()), [=](const Index begin, const Index end) {
    for (Index i = begin; i < end; ++i) to[i] += a * from[i];
  });
}

}  // namespace drench::kokkos_backend
