#pragma once
// Sums whose result does not depend on the number of threads: fixed partial sums, added in a fixed order.

#include "types.hpp"

namespace drench::kokkos_backend {

struct TwoSums {
  double first = 0, second = 0;
  KOKKOS_INLINE_FUNCTION TwoSums& operator+=(const TwoSums& o) {
    first += o.first;
    second += o.second;
    return *this;
  }
};

struct ThreeSums {
  double first = 0, second = 0, third = 0;
  KOKKOS_INLINE_FUNCTION ThreeSums& operator+=(const ThreeSums& o) {
    first += o.first;
    second += o.second;
    third += o.third;
    return *this;
  }
};

/// A sum with Neumaier's compensation: `lost` is what rounding took.
struct CompensatedSum {
  double sum = 0, lost = 0;
  KOKKOS_INLINE_FUNCTION CompensatedSum& operator+=(double t) {
    const double next = sum + t;
    lost += Kokkos::abs(sum) >= Kokkos::abs(t) ? (sum - next) + t : (t - next) + sum;
    sum = next;
    return *this;
  }
  KOKKOS_INLINE_FUNCTION CompensatedSum& operator+=(const CompensatedSum& o) {
    *this += o.sum;
    lost += o.lost;
    return *this;
  }
};

/// part(p) = Σ term(i) over i = p, p + parts, p + 2 parts, … < n.
template <class Sum, class Term, class Space>
void add_parts(const char* label, Index n, Index parts, const Term& term, const Kokkos::View<Sum*, Space>& part) {
  parallel(
      label, n < parts ? n : parts, KOKKOS_LAMBDA(const Index p) {
        Sum s{};
        for (Index i = p; i < n; i += parts) s += term(i);
        part(p) = s;
      });
}

/// Σ term(i), i < n, always in the same order: as many partial sums as keep a GPU busy, then fewer and fewer; the last few
/// are added by the host. Synchronises with the host.
template <class Sum, class Term>
Sum ordered(const char* label, Index n, const Term& term) {
  constexpr Index many = 65536, some = 1024, few = 32;
  static Kokkos::View<Sum*, Kokkos::SharedHostPinnedSpace> host_part;
  static Array<Sum> many_parts, some_parts;
  if (host_part.extent(0) == 0) {
    host_part = Kokkos::View<Sum*, Kokkos::SharedHostPinnedSpace>("drench::partial_sums", few);
    many_parts = Array<Sum>("drench::partial_sums", many);
    some_parts = Array<Sum>("drench::partial_sums", some);
    Kokkos::push_finalize_hook([] {
      host_part = {};
      many_parts = some_parts = {};
    });
  }
  const auto first = many_parts, second = some_parts;
  const Index parts = n < many ? n : many;
  add_parts(label, n, many, term, first);
  add_parts(
      label, parts, some, KOKKOS_LAMBDA(const Index i) { return first(i); }, second);
  add_parts(
      label, parts < some ? parts : some, few, KOKKOS_LAMBDA(const Index i) { return second(i); }, host_part);
  ExecSpace().fence(label);
  Sum total{};
  for (Index p = 0; p < few && p < n; ++p) total += host_part(p);
  return total;
}

/// Two sums at once, in double.
template <class Term>
TwoSums ordered_sums(const char* label, Index n, const Term& term) {
  return ordered<TwoSums>(label, n, term);
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
