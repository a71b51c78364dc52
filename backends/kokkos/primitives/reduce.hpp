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

/// Room for partial sums of any kind, in words of 8 bytes; grows on demand, freed with Kokkos.
struct SumRoom {
  Array<double> many, some;
  Kokkos::View<double*, Kokkos::SharedHostPinnedSpace> few;
};
inline SumRoom& sum_room() {
  static SumRoom room;
  static const bool hooked = [] {
    Kokkos::push_finalize_hook([] { room = {}; });
    return true;
  }();
  (void)hooked;
  return room;
}

/// `n` sums in that room.
template <class Sum, class Words>
auto sums_in(Words& words, Index n) {
  static_assert(sizeof(Sum) % sizeof(double) == 0 && alignof(Sum) <= alignof(double));
  const std::size_t needed = static_cast<std::size_t>(n) * (sizeof(Sum) / sizeof(double));
  if (words.extent(0) < needed) {
    words = {};  // free before allocating
    words = Words(Kokkos::ViewAllocateWithoutInitializing("drench::partial_sums"), needed);
  }
  return Kokkos::View<Sum*, typename Words::memory_space, Kokkos::MemoryTraits<Kokkos::Unmanaged>>(
      reinterpret_cast<Sum*>(words.data()), static_cast<std::size_t>(n));
}

/// part(p) = Σ term(i) over i = p, p + parts, p + 2 parts, … < n, for all of its p.
template <class Term, class Parts>
void add_parts(const char* label, Index n, const Term& term, const Parts& part) {
  const Index parts = static_cast<Index>(part.extent(0));
  parallel(
      label, parts, KOKKOS_LAMBDA(const Index p) {
        typename Parts::non_const_value_type s{};
        for (Index i = p; i < n; i += parts) s += term(i);
        part(p) = s;
      });
}

/// Σ term(i), i < n, always in the same order: as many partial sums as keep a GPU busy, then fewer and fewer; the last few
/// are added by the host. Synchronises with the host.
template <class Sum, class Term>
Sum ordered(const char* label, Index n, const Term& term) {
  constexpr Index many = 65536, some = 1024, few = 32;
  SumRoom& room = sum_room();
  const auto first = sums_in<Sum>(room.many, n < many ? n : many);
  const auto second = sums_in<Sum>(room.some, n < some ? n : some);
  const auto last = sums_in<Sum>(room.few, n < few ? n : few);
  add_parts(label, n, term, first);
  add_parts(
      label, static_cast<Index>(first.extent(0)), KOKKOS_LAMBDA(const Index i) { return first(i); }, second);
  add_parts(
      label, static_cast<Index>(second.extent(0)), KOKKOS_LAMBDA(const Index i) { return second(i); }, last);
  ExecSpace().fence(label);
  Sum total{};
  for (std::size_t p = 0; p < last.extent(0); ++p) total += last(p);
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
