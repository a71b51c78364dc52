// Radix sort on CUDA by CUB, which Thrust's sort_by_key runs too: here with temporaries that are kept, and over only as many
// bits as the buckets take.

#include <cub/device/device_radix_sort.cuh>
#include <stdexcept>
#include <string>

#include "core/bucket_sort.hpp"

namespace drench::kokkos_backend {
namespace {

using Key = std::uint32_t;

void write_keys(const CellTableView& t, const Array<Real3>& points, Index count, const Array<Key>& key) {
  const auto item = t.item;
  parallel(
      "drench::cell_table::radix_keys", count, KOKKOS_LAMBDA(const Index i) {
        key(i) = static_cast<Key>(bucket_of_point(t, points(i)));
        item(i) = i;
      });
}

void check(cudaError_t status) {
  if (status != cudaSuccess) throw std::runtime_error(std::string("radix sort: ") + cudaGetErrorString(status));
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
    cub::DoubleBuffer<Key> keys(key_.data(), next_key_.data());
    cub::DoubleBuffer<Index> items(table.item.data(), next_item_.data());
    const int bits = bits_of_buckets(table.buckets);
    const cudaStream_t stream = ExecSpace().cuda_stream();
    std::size_t wanted = 0;  // asked every time, on the host alone: how much it is depends on count and bits
    check(cub::DeviceRadixSort::SortPairs(nullptr, wanted, keys, items, count, 0, bits, stream));
    if (scratch_.extent(0) < wanted)
      scratch_ = Array<std::uint8_t>(Kokkos::ViewAllocateWithoutInitializing("drench::cell_radix_scratch"),
                                     wanted + wanted / 4);
    check(cub::DeviceRadixSort::SortPairs(scratch_.data(), wanted, keys, items, count, 0, bits, stream));
    if (keys.selector == 1) std::swap(key_, next_key_);
    if (items.selector == 1) std::swap(table.item, next_item_);
  }
  void read_out(CellTableView& table, Index count) override { find_starts(table, key_, count); }

 private:
  Array<Key> key_, next_key_;
  Array<Index> next_item_;
  Array<std::uint8_t> scratch_;
};

}  // namespace

std::shared_ptr<BucketSort> make_radix_sort() { return std::make_shared<RadixSort>(); }

}  // namespace drench::kokkos_backend
