// Radix sort on the host, least digit first: each of a few chunks of the particles counts its digits, a scan over (digit,
// chunk) says where they go, and each chunk carries its particles there in order. (Kokkos::Experimental::sort_by_key is a
// serial comparison sort there, and allocates in every call. For CUDA see cuda/radix_sort.cpp.)

#include <algorithm>

#include "core/radix_keys.hpp"

#ifndef KOKKOS_ENABLE_CUDA
namespace drench::kokkos_backend {
namespace {

using Key = RadixKeys::Key;
constexpr int most_bits = 11;  // of a digit: a chunk's counters and the lines that it writes to stay in a core's caches

/// One digit: from (key, item) to (next_key, next_item).
void sort_by_digit(Index count, int low_bit, int bits, Index chunks, const Array<Index>& offset, const Array<Key>& key,
                   const Array<Index>& item, const Array<Key>& next_key, const Array<Index>& next_item) {
  const Index digits = Index(1) << bits;
  const Key mask = static_cast<Key>(digits - 1);
  const Index length = (count + chunks - 1) / chunks;
  parallel(
      "drench::cell_table::radix_count", chunks, KOKKOS_LAMBDA(const Index c) {
        for (Index d = 0; d < digits; ++d) offset(d * chunks + c) = 0;
        const Index last = count - c * length < length ? count : (c + 1) * length;
        for (Index e = c * length; e < last; ++e) ++offset(static_cast<Index>(key(e) >> low_bit & mask) * chunks + c);
      });
  Kokkos::parallel_scan(
      "drench::cell_table::radix_scan", Range(0, digits * chunks),
      KOKKOS_LAMBDA(const Index k, Index& sum, const bool last) {
        const Index n = offset(k);
        if (last) offset(k) = sum;
        sum += n;
      });
  parallel(
      "drench::cell_table::radix_scatter", chunks, KOKKOS_LAMBDA(const Index c) {
        const Index last = count - c * length < length ? count : (c + 1) * length;
        for (Index e = c * length; e < last; ++e) {
          const Index slot = offset(static_cast<Index>(key(e) >> low_bit & mask) * chunks + c)++;
          next_key(slot) = key(e);
          next_item(slot) = item(e);
        }
      });
}

class RadixSort final : public RadixKeys {
 public:
  void sort(CellTableView& table, Index count) override {
    const int all = bits_of_buckets(table.buckets), passes = (all + most_bits - 1) / most_bits;
    const int bits = (all + passes - 1) / passes;
    // More chunks than threads only cost counters; a chunk of a few particles would be all counters.
    const Index chunks = std::max<Index>(1, std::min<Index>(ExecSpace().concurrency(), count >> bits));
    const auto places = static_cast<std::size_t>(chunks) << most_bits;
    make_room(offset_, "drench::cell_radix_place", places);
    for (int low = 0; low < all; low += bits) {
      sort_by_digit(count, low, bits, chunks, offset_, key_, table.item, next_key_, next_item_);
      std::swap(key_, next_key_);
      std::swap(table.item, next_item_);
    }
  }

 private:
  Array<Index> offset_;
};

}  // namespace

std::shared_ptr<BucketSort> make_radix_sort() { return std::make_shared<RadixSort>(); }

}  // namespace drench::kokkos_backend
#endif
