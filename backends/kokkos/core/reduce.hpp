#pragma once
// Sums whose result does not depend on the number of threads: fixed partial sums, added in a fixed order.

#include <algorithm>
#include <type_traits>

#include "core/ranks.hpp"
#include "core/sizing.hpp"
#include "core/types.hpp"
#include "core/workspace.hpp"

#ifdef KOKKOS_ENABLE_CUDA
#include "core/team_sums.hpp"
#endif

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

/// Of a host's sums: at most so many parts, which become a few, which one thread adds.
inline constexpr Index parts_of_sums[] = {4096, 32};

/// A host's parts of a sum: each has the next `length` of n terms.
struct SumParts {
  Index length, count;
  SumParts(Index n, Index most)
      : length(std::max(Index{64}, (n + most - 1) / most)), count((n + length - 1) / length) {}
};

inline SumRoom& sum_room() { return Workspace::current().sums; }

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

#ifndef KOKKOS_ENABLE_CUDA
/// Σ term(i) over part p of n terms.
template <class Sum, class Term>
Sum sum_of_part(Index p, Index n, const SumParts& parts, const Term& term) {
  Sum s{};
  const Index end = std::min(n, (p + 1) * parts.length);
  for (Index i = p * parts.length; i < end; ++i) s += term(i);
  return s;
}
template <class Sum, class Term>
void add_parts(const char* label, Index n, const Term& term, SumParts parts, Sum* part) {
  parallel(label, parts.count, [=](const Index p) { part[p] = sum_of_part<Sum>(p, n, parts, term); });
}
/// The same for two sums at once: the parts of the first, then those of the second.
template <class Sum, class First, class Second>
void add_pair_parts(const char* label, Index n_first, SumParts first_parts, const First& first, Index n_second,
                    SumParts second_parts, const Second& second, Sum* part) {
  parallel(label, first_parts.count + second_parts.count, [=](const Index p) {
    part[p] = p < first_parts.count ? sum_of_part<Sum>(p, n_first, first_parts, first)
                                    : sum_of_part<Sum>(p - first_parts.count, n_second, second_parts, second);
  });
}

/// Partial sums as terms.
template <class Sum>
struct PartsFrom {
  const Sum* part;
  const Sum& operator()(Index i) const { return part[i]; }
};
#endif

/// A term of a sum as Kokkos' reductions call it.
template <class Sum, class Term>
struct Added {
  Term term;
  KOKKOS_INLINE_FUNCTION void operator()(const Index i, Sum& s) const { s += term(i); }
};

/// What Kokkos makes of `add`(i, sum) for i < n, n > 0, in `result`; the host may read it after a fence.
template <class Sum, class Add>
void reduce_into(const char* label, Index n, const Add& add, Sum* result) {
  Kokkos::parallel_reduce(
      label, range(n), add,
      Kokkos::View<Sum, Kokkos::SharedHostPinnedSpace, Kokkos::MemoryTraits<Kokkos::Unmanaged>>(result));
}
/// The same. Synchronises with the host.
template <class Sum, class Add>
Sum reduced(const char* label, Index n, const Add& add) {
  if (n == 0) return {};
  const auto one = sums_in<Sum>(sum_room().few, 1);
  reduce_into(label, n, add, one.data());
  exec().fence(label);
  return one(0);
}

/// Two sums of the same kind over different ranges.
template <class Sum>
struct SumPair {
  Sum first, second;
};

/// A sum that `begin_ordered` has begun, and where it arrives.
template <class Sum>
struct SumUnderWay {
  const char* label = nullptr;
  const Sum* total = nullptr;
  std::size_t parts = 0;

  /// Synchronises with the host.
  Sum wait() const {
    exec().fence(label);
    return arrived();
  }
  /// Once the host has waited for this kernel or a later one.
  Sum arrived() const {
    Sum all{};
    for (std::size_t p = 0; p < parts; ++p) all += total[p];
    return all;
  }
};

/// Begins with Σ term(i), i < n, always in the same order. Two may be under way at once, with a different `slot` (0 or
/// 1); until the first is read the room must not grow: no sums of a larger kind in between.
template <class Sum, class Term>
SumUnderWay<Sum> begin_ordered(const char* label, Index n, const Term& term, int slot = 0) {
  // On CUDA the blocks and the order of Kokkos' reduction depend on n and the kernel alone (core/thread_mapping.hpp
  // looks), on a CPU on the threads too.
  constexpr Index most_parts = parts_of_sums[1];
  if (n == 0) return {label, nullptr, 0};
  SumRoom& room = sum_room();
  Sum* const at = sums_in<Sum>(room.few, 2 * most_parts).data() + (slot == 0 ? 0 : most_parts);
#ifdef KOKKOS_ENABLE_CUDA
  reduce_into(label, n, Added<Sum, Term>{term}, at);
  return {label, at, 1};
#else
  const SumParts many(n, parts_of_sums[0]), few(many.count, most_parts);
  const auto part = sums_in<Sum>(room.many, many.count);
  add_parts(label, n, term, many, part.data());
  add_parts(label, many.count, PartsFrom<Sum>{part.data()}, few, at);
  return {label, at, static_cast<std::size_t>(few.count)};
#endif
}

/// Σ term(i), i < n, always in the same order. Synchronises with the host.
template <class Sum, class Term>
Sum ordered(const char* label, Index n, const Term& term) {
  if (n == 0) return {};
  return begin_ordered<Sum>(label, n, term).wait();
}

/// Both sums, always in the same order, with the same kernels and one wait for both. On a GPU by teams: with terms as
/// large as the ledger's that is several times as fast as a reduction of Kokkos, with a few numbers slower.
template <class Sum, class First, class Second>
SumPair<Sum> ordered_pair(const char* label, Index n_first, const First& first, Index n_second, const Second& second) {
  SumRoom& room = sum_room();
#ifdef KOKKOS_ENABLE_CUDA
  if (n_first + n_second == 0) return {};
  using Sums = TeamSums<Sum, First, Second>;
  if (room.finished.data() == nullptr)
    room.finished = Kokkos::View<unsigned, MemSpace>("drench::partial_sums::finished");
  const Index a = Sums::teams(n_first), b = Sums::teams(n_second);
  const auto part = sums_in<Sum>(room.many, a + b);
  const auto both = sums_in<Sum>(room.few, 2);
  Teams policy(exec(), a + b, Sums::threads);
  policy.set_scratch_size(0, Kokkos::PerTeam(Sums::Scratch::shmem_size(Sums::threads)));
  const Sums sums{n_first, n_second, a, b, first, second, part.data(), both.data(), room.finished.data()};
  Kokkos::parallel_for(label, policy, sums);
  exec().fence(label);
  return {both(0), both(1)};
#else
  const SumParts many_a(n_first, parts_of_sums[0]), many_b(n_second, parts_of_sums[0]),
      few_a(many_a.count, parts_of_sums[1]), few_b(many_b.count, parts_of_sums[1]);
  const auto many = sums_in<Sum>(room.many, many_a.count + many_b.count);
  const auto few = sums_in<Sum>(room.few, few_a.count + few_b.count);
  add_pair_parts(label, n_first, many_a, first, n_second, many_b, second, many.data());
  add_pair_parts(label, many_a.count, few_a, PartsFrom<Sum>{many.data()}, many_b.count, few_b,
                 PartsFrom<Sum>{many.data() + many_a.count}, few.data());
  exec().fence(label);
  SumPair<Sum> total;
  for (Index p = 0; p < few_a.count; ++p) total.first += few(p);
  for (Index p = 0; p < few_b.count; ++p) total.second += few(few_a.count + p);
  return total;
#endif
}

/// How many partial sums ordered_pair keeps of one of its ranges, with n terms, and what they take if one has `sum`
/// bytes.
inline double partial_sums(double n, const Sizing& s) {
  if (s.gpu) return std::min(512.0, n / 128 + 1);  // TeamSums::teams
  return std::min(double(parts_of_sums[0]), n / 64 + 1) + parts_of_sums[1];
}
inline double sum_room_bytes(double sums, double sum) { return 1.25 * sum * sums; }

/// Two sums at once, in double.
template <class Term>
TwoSums ordered_sums(const char* label, Index n, const Term& term) {
  return ordered<TwoSums>(label, n, term);
}

/// Begins with max term(i), n > 0, in double, left in `result`, which the device can write.
template <class Term, class Space>
void find_maximum(const char* label, Index n, const Term& term, const Kokkos::View<double, Space>& result) {
  Kokkos::parallel_reduce(
      label, range(n),
      KOKKOS_LAMBDA(const Index i, double& m) {
        const double t = term(i);
        if (t > m) m = t;
      },
      Kokkos::Max<double, Space>(result));
}

/// Maxima whose kernels run while the host goes on.
class MaximaUnderWay {
 public:
  /// max term(i); nothing if n = 0. At most three.
  template <class Term>
  void add(const char* label, Index n, const Term& term) {
    if (n == 0) return;
    auto& result = sum_room().maximum[count_++];
    if (result.data() == nullptr) result = std::decay_t<decltype(result)>("drench::maximum");
    find_maximum(label, n, term, result);
  }
  /// The largest of all, on all ranks; 0 if none is larger. Synchronises with the host.
  double wait(const char* label, const Communicator* ranks = nullptr) const {
    double most = 0;
    if (count_ > 0) exec().fence(label);
    for (std::size_t k = 0; k < count_; ++k) most = Kokkos::max(most, sum_room().maximum[k]());
    OverRanks(ranks).maximum(most).reduce();
    return most;
  }

 private:
  std::size_t count_ = 0;
};

/// max term(i) (0 if n = 0), in double. Synchronises with the host.
template <class Term>
double maximum(const char* label, Index n, const Term& term) {
  MaximaUnderWay one;
  one.add(label, n, term);
  return one.wait(label);
}

}  // namespace drench::kokkos_backend
