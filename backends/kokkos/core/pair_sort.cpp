// Radix sort on the host, least digit first: each of a few chunks of the pairs counts its digits, a scan over (digit,
// chunk) says where they go, and each chunk carries its pairs there in order. (Kokkos::Experimental::sort_by_key is a
// serial comparison sort there, and allocates in every call. For CUDA see cuda/pair_sort.cpp.)

#include "core/pair_sort.hpp"

#include <algorithm>

#ifndef KOKKOS_ENABLE_CUDA
namespace drench::kokkos_backend {
namespace {

using Key = PairSort::Key;
constexpr int most_bits = 11;  // of a digit: a chunk's counters and the lines that it writes to stay in a core's caches

/// One digit: from (key, item) to (next_key, next_item).
void sort_by_digit(Index count, int low_bit, int bits, Index chunks, const Array<Index>& offset, const Array<Key>& key,
                   const Array<Index>& item, const Array<Key>& next_key, const Array<Index>& next_item) {
  const Index digits = Index(1) << bits;
  const Key mask = static_cast<Key>(digits - 1);
  const Index length = (count + chunks - 1) / chunks;
  parallel(
      "drench::pair_sort::count", chunks, KOKKOS_LAMBDA(const Index c) {
        for (Index d = 0; d < digits; ++d) offset(d * chunks + c) = 0;
        const Index last = count - c * length < length ? count : (c + 1) * length;
        for (Index e = c * length; e < last; ++e) ++offset(static_cast<Index>(key(e) >> low_bit & mask) * chunks + c);
      });
  Kokkos::parallel_scan(
      "drench::pair_sort::scan", Range(0, digits * chunks), KOKKOS_LAMBDA(const Index k, Index& sum, const bool last) {
        const Index n = offset(k);
        if (last) offset(k) = sum;
        sum += n;
      });
  parallel(
      "drench::pair_sort::scatter", chunks, KOKKOS_LAMBDA(const Index c) {
        const Index last = count - c * length < length ? count : (c + 1) * length;
        for (Index e = c * length; e < last; ++e) {
          const Index slot = offset(static_cast<Index>(key(e) >> low_bit & mask) * chunks + c)++;
          next_key(slot) = key(e);
          next_item(slot) = item(e);
        }
      });
}

}  // namespace

void sort_pairs(PairSort& pairs, Index count, int bits) {
  const int passes = (bits + most_bits - 1) / most_bits, digit = (bits + passes - 1) / passes;
  make_room(pairs.next_key, "drench::pair_sort::key", pairs.key.extent(0));
  make_room(pairs.next_item, "drench::pair_sort::item", pairs.item.extent(0));
  // More chunks than threads only cost counters; a chunk of a few pairs would be all counters.
  const Index chunks = std::max<Index>(1, std::min<Index>(exec().concurrency(), count >> digit));
  make_room(pairs.place, "drench::pair_sort::place", static_cast<std::size_t>(chunks) << most_bits);
  for (int low = 0; low < bits; low += digit) {
    sort_by_digit(count, low, digit, chunks, pairs.place, pairs.key, pairs.item, pairs.next_key, pairs.next_item);
    std::swap(pairs.key, pairs.next_key);
    std::swap(pairs.item, pairs.next_item);
  }
}

}  // namespace drench::kokkos_backend
#endif
