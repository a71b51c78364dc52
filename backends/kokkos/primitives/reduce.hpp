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
    words = Words(Kokkos::ViewAllocateWithoutInitializing("drench::partial_sums"), needed + needed / 4);
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

/// A term of a sum as Kokkos' reductions call it.
template <class Sum, class Term>
struct Added {
  Term term;
  KOKKOS_INLINE_FUNCTION void operator()(const Index i, Sum& s) const { s += term(i); }
};

/// What Kokkos makes of `add`(i, sum) for i < n. Synchronises with the host.
template <class Sum, class Add>
Sum reduced(const char* label, Index n, const Add& add) {
  if (n == 0) return {};
  const auto one = sums_in<Sum>(sum_room().few, 1);
  Kokkos::parallel_reduce(
      label, Range(0, n), add,
      Kokkos::View<Sum, Kokkos::SharedHostPinnedSpace, Kokkos::MemoryTraits<Kokkos::Unmanaged>>(one.data()));
  ExecSpace().fence(label);
  return one(0);
}

/// Σ term(i), i < n, always in the same order. Synchronises with the host. On CUDA it is a reduction of Kokkos, whose blocks
/// and order depend on n and the kernel alone. On a CPU their number would depend on the threads: there as many partial sums
/// as keep a GPU busy, then fewer and fewer; the last few are added by the host.
template <class Sum, class Term>
Sum ordered(const char* label, Index n, const Term& term) {
#ifdef KOKKOS_ENABLE_CUDA
  return reduced<Sum>(label, n, Added<Sum, Term>{term});
#else
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
#endif
}

/// add_parts for two sums at once: the parts of the first, then those of the second.
template <class First, class Second, class Parts>
void add_pair_parts(const char* label, Index n_first, Index first_parts, const First& first, Index n_second,
                    Index second_parts, const Second& second, const Parts& part) {
  parallel(
      label, first_parts + second_parts, KOKKOS_LAMBDA(const Index p) {
        typename Parts::non_const_value_type s{};
        if (p < first_parts)
          for (Index i = p; i < n_first; i += first_parts) s += first(i);
        else
          for (Index i = p - first_parts; i < n_second; i += second_parts) s += second(i);
        part(p) = s;
      });
}

/// Partial sums as terms.
template <class Sum>
struct PartsFrom {
  const Sum* part;
  KOKKOS_INLINE_FUNCTION const Sum& operator()(Index i) const { return part[i]; }
};

/// Two sums of the same kind over different ranges, by partial sums as in `ordered`: the same kernels and one wait for both. Also
/// on CUDA: for terms as large as the ledger's a reduction of Kokkos takes several times as long.
template <class Sum>
struct SumPair {
  Sum first, second;
};
template <class Sum, class First, class Second>
SumPair<Sum> ordered_pair(const char* label, Index n_first, const First& first, Index n_second, const Second& second) {
  constexpr Index sizes[] = {65536, 1024, 32};
  SumRoom& room = sum_room();
  Index a[3], b[3];
  for (int level = 0; level < 3; ++level) {
    a[level] = n_first < sizes[level] ? n_first : sizes[level];
    b[level] = n_second < sizes[level] ? n_second : sizes[level];
  }
  const auto many = sums_in<Sum>(room.many, a[0] + b[0]);
  const auto some = sums_in<Sum>(room.some, a[1] + b[1]);
  const auto few = sums_in<Sum>(room.few, a[2] + b[2]);
  add_pair_parts(label, n_first, a[0], first, n_second, b[0], second, many);
  add_pair_parts(label, a[0], a[1], PartsFrom<Sum>{many.data()}, b[0], b[1], PartsFrom<Sum>{many.data() + a[0]}, some);
  add_pair_parts(label, a[1], a[2], PartsFrom<Sum>{some.data()}, b[1], b[2], PartsFrom<Sum>{some.data() + a[1]}, few);
  ExecSpace().fence(label);
  SumPair<Sum> total;
  for (Index p = 0; p < a[2]; ++p) total.first += few(p);
  for (Index p = 0; p < b[2]; ++p) total.second += few(a[2] + p);
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
