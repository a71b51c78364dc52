#pragma once
// Sums whose result does not depend on the number of threads: fixed partial sums, added in a fixed order.

#include "types.hpp"

namespace drench::kokkos_backend {

inline constexpr Index partial_sums = 1024;

struct TwoSums {
  double first = 0, second = 0;
  KOKKOS_INLINE_FUNCTION TwoSums& operator+=(const TwoSums& o) {
    first += o.first;
    second += o.second;
    return *this;
  }
};

/// Σ term(i), i < n, of two numbers at once, always in the same order. Synchronises with the host.
template <class Term>
TwoSums ordered_sums(const char* label, Index n, const Term& term) {
  static Array<TwoSums> partial;
  static Kokkos::View<TwoSums, MemSpace> whole;
  if (n <= 0) return {};
  if (partial.extent(0) == 0) {
    partial = Array<TwoSums>("drench::partial_sums", partial_sums);
    whole = Kokkos::View<TwoSums, MemSpace>("drench::whole_sum");
    Kokkos::push_finalize_hook([] {
      partial = {};
      whole = {};
    });
  }
  const auto sums = partial;
  const auto total = whole;
  parallel(
      label, partial_sums, KOKKOS_LAMBDA(const Index b) {
        TwoSums s;
        for (Index i = b; i < n; i += partial_sums) s += term(i);
        sums(b) = s;
      });
  parallel(
      label, 1, KOKKOS_LAMBDA(const Index) {
        TwoSums s;
        for (Index b = 0; b < partial_sums; ++b) s += sums(b);
        total() = s;
      });
  TwoSums result;
  Kokkos::deep_copy(result, total);
  return result;
}

/// Σ term(i), i < n, in double, always in the same order. Synchronises with the host.
template <class Term>
double ordered_sum(const char* label, Index n, const Term& term) {
  return ordered_sums(
             label, n,
             KOKKOS_LAMBDA(const Index i) {
               return TwoSums{term(i), 0};
             })
      .first;
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
