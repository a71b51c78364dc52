// Radix sort on CUDA by CUB, which Thrust's sort_by_key runs too: here with temporaries that are kept, and over only as
// many bits as the buckets take.

#include "core/pair_sort.hpp"

#include <cub/device/device_radix_sort.cuh>

#include "core/cuda/check.hpp"

namespace drench::kokkos_backend {

void sort_pairs(PairSort& pairs, Index count, int bits) {
  make_room(pairs.next_key, "drench::pair_sort::key", pairs.key.extent(0));
  make_room(pairs.next_item, "drench::pair_sort::item", pairs.item.extent(0));
  cub::DoubleBuffer<PairSort::Key> keys(pairs.key.data(), pairs.next_key.data());
  cub::DoubleBuffer<Index> items(pairs.item.data(), pairs.next_item.data());
  const cudaStream_t stream = exec().cuda_stream();
  std::size_t wanted = 0;  // asked every time, on the host alone: how much it is depends on count and bits
  check(cub::DeviceRadixSort::SortPairs(nullptr, wanted, keys, items, count, 0, bits, stream), "radix sort");
  make_ample_room(pairs.scratch, "drench::pair_sort::scratch", wanted);
  check(cub::DeviceRadixSort::SortPairs(pairs.scratch.data(), wanted, keys, items, count, 0, bits, stream),
        "radix sort");
  if (keys.selector == 1) std::swap(pairs.key, pairs.next_key);
  if (items.selector == 1) std::swap(pairs.item, pairs.next_item);
}

}  // namespace drench::kokkos_backend
