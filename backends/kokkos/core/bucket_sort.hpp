#pragma once
// The sorts behind a cell table. Each orders the particles by bucket and leaves the order within a bucket open: the
// table settles that by (cell, key), so that all of them end in the same table, bit for bit.

#include <memory>

#include "core/cell_table.hpp"
#include "core/pair_sort.hpp"
#include "scene/scene.hpp"

namespace drench::kokkos_backend {

/// What `sort: auto` takes, on every backend: the fastest that was measured. tools/measure/bench_neighbors has it first
/// on an H200 at every size (800 k particles, keys to table: 0.06 ms; radix 0.11, bitonic 0.28, the paper's bitonic
/// 1.55) and on CPU cores from 32,768 particles on (radix by a tenth below).
inline constexpr SortMethod fastest_sort = SortMethod::counting;

class BucketSort {
 public:
  virtual ~BucketSort() = default;
  /// Computes the buckets of `count` > 0 points; 0 for a point that is not finite.
  virtual void make_keys(CellTableView& table, const Array<Real3>& points, Index count) = 0;
  virtual void sort(CellTableView& table, Index count) = 0;
  /// Leaves in `table` the arrays `start` and `item`, as long as they were; may exchange `item` for an array of its
  /// own.
  virtual void read_out(CellTableView& table, Index count) = 0;
};

/// Makes the sort; its work arrays are allocated when the first particles come.
std::shared_ptr<BucketSort> make_bucket_sort(SortMethod method);
std::shared_ptr<BucketSort> make_counting_sort();
std::shared_ptr<BucketSort> make_radix_sort();  // for CUDA in core/cuda/
std::shared_ptr<BucketSort> make_bitonic_sort(bool naive);

/// Of the sort that `sort: auto` takes, in a table with room for so many points.
double sort_bytes(double room);

/// The bucket of a point, in a kernel of make_keys.
KOKKOS_INLINE_FUNCTION Index bucket_of_point(const CellTableView& table, const Real3& point) {
  const Index k = table.bucket_of(table.cell_of(point));
  return k < 0 ? 0 : k;  // not finite: the ledger stage will stop the run
}

/// How many bits the numbers below `buckets` take, at least 1.
inline int bits_of_buckets(Index buckets) {
  int bits = 1;
  while (bits < 31 && (buckets - 1) >> bits != 0) ++bits;
  return bits;
}

// The keys of the comparison and radix sorts: a bucket, or a bucket above the particle's index.
KOKKOS_INLINE_FUNCTION Index bucket_of_key(std::uint32_t key) { return static_cast<Index>(key); }
KOKKOS_INLINE_FUNCTION Index bucket_of_key(std::uint64_t key) { return static_cast<Index>(key >> 32); }

/// Fills table.start from sorted keys: where the first key stands that is not below the bucket. A search by halves for
/// every bucket, because a particle that wrote the gap before it would leave a long one to a single thread.
template <class Key>
void find_starts(const CellTableView& table, const Array<Key>& sorted, Index count) {
  const auto start = table.start;
  parallel(
      "drench::cell_table::starts", table.buckets + 1, KOKKOS_LAMBDA(const Index k) {
        Index first = 0, last = count;
        while (first < last) {
          const Index middle = first + (last - first) / 2;
          if (bucket_of_key(sorted(middle)) < k)
            first = middle + 1;
          else
            last = middle;
        }
        start(k) = first;
      });
}

}  // namespace drench::kokkos_backend
