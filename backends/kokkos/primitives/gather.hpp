#pragma once
// Sums over the rows of a list by several lanes a row on a GPU: a cloth has too few nodes to keep one busy by themselves.

#include <cstdint>
#include <cstring>
#include <type_traits>

#include "types.hpp"

namespace drench::kokkos_backend {

#ifdef KOKKOS_ENABLE_CUDA
inline constexpr Index row_lanes = 8;
#else
inline constexpr Index row_lanes = 1;
#endif

/// The sum over a row's lanes, in all of them, always in the same order.
template <class Sum>
KOKKOS_INLINE_FUNCTION Sum sum_of_lanes(Sum s) {
#ifdef __CUDA_ARCH__
  static_assert(std::is_trivially_copyable_v<Sum> && sizeof(Sum) % sizeof(unsigned) == 0);
  constexpr int words = sizeof(Sum) / sizeof(unsigned);
  const unsigned mine = ((1u << row_lanes) - 1) << (threadIdx.y % 32 / row_lanes * row_lanes);
  for (int apart = row_lanes / 2; apart > 0; apart /= 2) {
    unsigned word[words];
    memcpy(word, &s, sizeof(Sum));
    for (int w = 0; w < words; ++w) word[w] = __shfl_down_sync(mine, word[w], apart, row_lanes);
    Sum other;
    memcpy(&other, word, sizeof(Sum));
    s += other;
  }
#endif
  return s;
}

/// finish(n, Σ term(e)) for each row n < rows, e from start(n) to start(n + 1). (Ranges of Kokkos lie along threadIdx.y, and
/// begin at 0: the lanes of a row are neighbours in a warp.)
template <class Sum, class Term, class Finish>
void gather_rows(const char* label, Index rows, const Entries<Index>& start, const Term& term, const Finish& finish) {
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
