#pragma once
// Sums whose result does not depend on the number of threads: fixed partial sums, added in a fixed order.

#include "types.hpp"

namespace drench::kokkos_backend {

inline constexpr Index partial_sums = 1024;

/// Σ term(i), i < n, in double, always in the same order. Synchronises with the host.
template <class Term>
double ordered_sum(const char* label, Index n, const Term& term) {
  static Array<double> partial;
  if (n <= 0) return 0;
  if (partial.extent(0) == 0) {
    partial = Array<double>("drench::partial_sums", partial_sums);
    Kokkos::push_finalize_hook([] { partial = {}; });
  }
  const auto sums = partial;
  parallel(
      label, partial_sums, KOKKOS_LAMBDA(const Index b) {
        double s = 0;
        for (Index i = b; i < n; i += partial_sums) s += term(i);
        sums(b) = s;
      });
  double total = 0;
  Kokkos::parallel_reduce(
      label, Range(0, 1),
      KOKKOS_LAMBDA(const Index, double& t) {
        for (Index b = 0; b < partial_sums; ++b) t += sums(b);
      },
      total);
  return total;
}

/// max term(i) (0 if n = 0), in double. Synchronises with the host.
template <class Term>
double maximum(const char* label, Index n, const Term& term) {
  double result = 0;
  if (n > 0)
    Kokkos::parallel_reduce(
        label, Range(0, n),
        KOKKOS_LAMBDA(const Index i, double& m) {
          const double t = term(i);
          if (t > m) m = t;
        },
        Kokkos::Max<double>(result));
  return n > 0 && result > -1e300 ? result : 0;
}

/// Σ term(i) in 64-bit integers: exact in any order. Synchronises with the host.
template <class Term>
std::int64_t integer_sum(const char* label, Index n, const Term& term) {
  std::int64_t result = 0;
  if (n > 0)
    Kokkos::parallel_reduce(
        label, Range(0, n), KOKKOS_LAMBDA(const Index i, std::int64_t& s) { s += term(i); }, result);
  return result;
}

}  // namespace drench::kokkos_backend
