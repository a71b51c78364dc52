// Radix sort on the host, least digit first: each of a few chunks of the particles counts its digits, a scan over (digit,
// chunk) says where they go, and each chunk carries its particles there in order. (Kokkos::Experimental::sort_by_key is a
// serial comparison sort there, and allocates in every call. For CUDA see cuda/radix_sort.cpp.)

#include <algorithm>

#include "core/bucket_sort.hpp"

#ifndef KOKKOS_ENABLE_CUDA
namespace drench::kokkos_backend {
namespace {

using Key = std::uint32_t;
constexpr int most_bits = 11;  // of a digit: a chunk's counters and the lines that it writes to stay in a core's caches

void write_keys(const CellTableView& t, const Array<Real3>& points, Index count, const Array<Key>& key) {
  const auto item = t.item;
  parallel(
      "drench::cell_table::radix_keys", count, KOKKOS_LAMBDA(const Index i) {
        key(i) = static_cast<Key>(bucket_of_point(t, points(i)));
        item(i) = i;
      });
}

/// One digit: from (key, item) to (next_key, next_item).
void sort_by_digit(Index count, int low_bit, int bits, Index chunks, const Array<Index>& place, const Array<Key>& key,
                   const Array<Index>& item, const Array<Key>& next_key, const Array<Index>& next_item) {
  const Index digits = Index(1) << bits;
  const Key mask = static_cast<Key>(digits - 1);
  const Index length = (count + chunks - 1) / chunks;
  parallel(
      "drench::cell_table::radix_count", chunks, KOKKOS_LAMBDA(const Index c) {
        for (Index d = 0; d < digits; ++d) place(d * chunks + c) = 0;
        const Index last = count - c * length < length ? count : (c + 1) * length;
        for (Index e = c * length; e < last; ++e) ++place(static_cast<Index>(key(e) >> low_bit & mask) * chunks + c);
      });
  Kokkos::parallel_scan(
      "drench::cell_table::radix_scan", Range(0, digits * chunks),
      KOKKOS_LAMBDA(const Index k, Index& sum, const bool last) {
        const Index n = place(k);
        if (last) place(k) = sum;
        sum += n;
      });
  parallel(
      "drench::cell_table::radix_scatter", chunks, KOKKOS_LAMBDA(const Index c) {
        const Index last = count - c * length < length ? count : (c + 1) * length;
        for (Index e = c * length; e < last; ++e) {
          const Index slot = place(static_cast<Index>(key(e) >> low_bit & mask) * chunks + c)++;
          next_key(slot) = key(e);
          next_item(slot) = item(e);
        }
      });
}

class RadixSort final : public BucketSort {
 public:
  void make_keys(CellTableView& table, const Array<Real3>& points, Index count) override {
    const auto n = table.item.extent(0);
    if (key_.extent(0) < n) {
      key_ = Array<Key>(Kokkos::ViewAllocateWithoutInitializing("drench::cell_radix_key"), n);
      next_key_ = Array<Key>(Kokkos::ViewAllocateWithoutInitializing("drench::cell_radix_next_key"), n);
      next_item_ = Array<Index>(Kokkos::ViewAllocateWithoutInitializing("drench::cell_radix_next_item"), n);
    }
    write_keys(table, points, count, key_);
  }
  void sort(CellTableView& table, Index count) override {
    const int all = bits_of_buckets(table.buckets), passes = (all + most_bits - 1) / most_bits;
    const int bits = (all + passes - 1) / passes;
    // More chunks than threads only cost counters; a chunk of a few particles would be all counters.
    const Index chunks = std::max<Index>(1, std::min<Index>(ExecSpace().concurrency(), count >> bits));
    const auto places = static_cast<std::size_t>(chunks) << most_bits;
    if (place_.extent(0) < places)
      place_ = Array<Index>(Kokkos::ViewAllocateWithoutInitializing("drench::cell_radix_place"), places);
    for (int low = 0; low < all; low += bits) {
      sort_by_digit(count, low, bits, chunks, place_, key_, table.item, next_key_, next_item_);
      std::swap(key_, next_key_);
      std::swap(table.item, next_item_);
    }
  }
  void read_out(CellTableView& table, Index count) override { find_starts(table, key_, count); }

 private:
  Array<Key> key_, next_key_;
  Array<Index> next_item_, place_;
};

}  // namespace

std::shared_ptr<BucketSort> make_radix_sort() { return std::make_shared<RadixSort>(); }

}  // namespace drench::kokkos_backend
#endif
