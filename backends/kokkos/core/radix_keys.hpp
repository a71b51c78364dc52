#pragma once
// The radix sorts of host and GPU begin and end alike: the buckets are the keys, and sorted keys say where a bucket starts.

#include "core/bucket_sort.hpp"

namespace drench::kokkos_backend {

class RadixKeys : public BucketSort {
 public:
  using Key = std::uint32_t;
  void make_keys(CellTableView& table, const Array<Real3>& points, Index count) final;
  void read_out(CellTableView& table, Index count) final;

 protected:
  Array<Key> key_, next_key_;
  Array<Index> next_item_;
};

}  // namespace drench::kokkos_backend
