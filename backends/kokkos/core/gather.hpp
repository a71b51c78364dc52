#pragma once
// Sums over the rows of a list by several lanes a row on a GPU: a cloth has too few nodes to keep one busy by
// themselves.

#include <cstdint>
#include <cstring>
#include <type_traits>

#include "core/types.hpp"

namespace drench::kokkos_backend {

#ifdef KOKKOS_ENABLE_CUDA
inline constexpr Index row_lanes = 8;
#else
inline constexpr Index row_lanes = 1;
#endif
inline constexpr Index rows_at_once = 1 << 15;  // that lanes of their own fill a large GPU with
static_assert(row_lanes < warp_size && warp_size % row_lanes == 0, "a warp has whole rows");
static_assert(!on_host || row_lanes == 1, "a thread of the host has a row to itself");

/// What the lane has that is `apart` from this one, among the `lanes` that share a row. (Ranges of Kokkos lie along
/// threadIdx.y, and begin at 0: the lanes of a row are neighbours in a warp. core/thread_mapping.hpp checks it.)
template <Index lanes = row_lanes, class Value>
KOKKOS_INLINE_FUNCTION Value of_other_lane(const Value& mine, [[maybe_unused]] int apart) {
#ifdef __CUDA_ARCH__
  static_assert(std::is_trivially_copyable_v<Value> && sizeof(Value) % sizeof(unsigned) == 0);
#ifdef DRENCH_CHECK_BOUNDS  // Kokkos chooses each kernel's block
  if (blockDim.x != 1 || blockDim.y % lanes != 0) Kokkos::abort("drench: a row's lanes lie in two blocks");
#endif
  constexpr int words = sizeof(Value) / sizeof(unsigned);
  const unsigned together = 0xffffffffu >> (warp_size - lanes) << (threadIdx.y % warp_size / lanes * lanes);
  unsigned word[words];
  memcpy(word, &mine, sizeof(Value));
  for (int w = 0; w < words; ++w) word[w] = __shfl_xor_sync(together, word[w], apart, lanes);
  Value other;
  memcpy(&other, word, sizeof(Value));
  return other;
#else
  return mine;
#endif
}

/// Whether it is so in any of a row's lanes.
KOKKOS_INLINE_FUNCTION bool any_of_lanes(bool mine) {
#ifdef __CUDA_ARCH__
  const unsigned first = threadIdx.y % warp_size / row_lanes * row_lanes;
  return __any_sync(0xffffffffu >> (warp_size - row_lanes) << first, mine);
#else
  return mine;
#endif
}

/// The sum over a row's lanes, in all of them, always in the same order.
template <class Sum>
KOKKOS_INLINE_FUNCTION Sum sum_of_lanes(Sum s) {
  for (int apart = row_lanes / 2; apart > 0; apart /= 2) s += of_other_lane(s, apart);
  return s;
}

/// body(n, lane) for each row n < rows by all of its lanes; each takes every row_lanes-th of the row's entries from
/// `lane` on.
template <class Body>
void parallel_rows(const char* label, Index rows, const Body& body) {
  if constexpr (on_host) {
    parallel(
        label, rows, KOKKOS_LAMBDA(const Index n) { body(n, 0); });
  } else {
    const Index groups = rows < rows_at_once ? rows : rows_at_once;
    parallel(
        label, groups * row_lanes, KOKKOS_LAMBDA(const Index thread) {
          for (Index n = thread / row_lanes; n < rows; n += groups) body(n, thread % row_lanes);
        });
  }
}

/// finish(n, Σ term(e)) for each row n < rows, e from start(n) to start(n + 1).
template <class Sum, class Term, class Finish>
void gather_rows(const char* label, Index rows, const Entries<const Index>& start, const Term& term,
                 const Finish& finish) {
  parallel(
      label, rows * row_lanes, KOKKOS_LAMBDA(const Index k) {
        const Index n = k / row_lanes, lane = k % row_lanes, last = start(n + 1);
        Sum sum{};
        DRENCH_UNROLL
        for (Index e = start(n) + lane; e < last; e += row_lanes) sum += term(e);
        sum = sum_of_lanes(sum);
        if (lane == 0) finish(n, sum);
      });
}

}  // namespace drench::kokkos_backend
