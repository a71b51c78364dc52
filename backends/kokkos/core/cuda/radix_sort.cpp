// Radix sort on CUDA by CUB, which Thrust's sort_by_key runs too: here with temporaries that are kept, and over only as many
// bits as the buckets take.

#include <cub/device/device_radix_sort.cuh>
#include <stdexcept>
#include <string>

#include "core/radix_keys.hpp"

namespace drench::kokkos_backend {
namespace {

void check(cudaError_t status) {
  if (status != cudaSuccess) throw std::runtime_error(std::string("radix sort: ") + cudaGetErrorString(status));
}

class RadixSort final : public RadixKeys {
 public:
  void sort(CellTableView& table, Index count) override {
    cub::DoubleBuffer<Key> keys(key_.data(), next_key_.data());
    cub::DoubleBuffer<Index> items(table.item.data(), next_item_.data());
    const int bits = bits_of_buckets(table.buckets);
    const cudaStream_t stream = ExecSpace().cuda_stream();
    std::size_t wanted = 0;  // asked every time, on the host alone: how much it is depends on count and bits
    check(cub::DeviceRadixSort::SortPairs(nullptr, wanted, keys, items, count, 0, bits, stream));
    make_ample_room(scratch_, "drench::cell_radix_scratch", wanted);
    check(cub::DeviceRadixSort::SortPairs(scratch_.data(), wanted, keys, items, count, 0, bits, stream));
    if (keys.selector == 1) std::swap(key_, next_key_);
    if (items.selector == 1) std::swap(table.item, next_item_);
  }

 private:
  Array<std::uint8_t> scratch_;
};

}  // namespace

std::shared_ptr<BucketSort> make_radix_sort() { return std::make_shared<RadixSort>(); }

}  // namespace drench::kokkos_backend
