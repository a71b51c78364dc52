// Counting sort: histogram, exclusive scan, scatter. The scan is already the table's `start`.

#include "primitives/bucket_sort.hpp"

namespace drench::kokkos_backend {
namespace {

void count_buckets(const CellTableView& t, const Array<Real3>& points, Index count, const Array<Index>& bucket,
                   const Array<Index>& cursor) {
  parallel(
      "drench::cell_table::clear", t.buckets + 1, KOKKOS_LAMBDA(const Index k) { cursor(k) = 0; });
  parallel(
      "drench::cell_table::count", count, KOKKOS_LAMBDA(const Index i) {
        const Index k = bucket_of_point(t, points(i));
        bucket(i) = k;
        Kokkos::atomic_inc(&cursor(k));
      });
}

void scan_and_scatter(const CellTableView& t, Index count, const Array<Index>& bucket, const Array<Index>& cursor) {
  const auto start = t.start, item = t.item;
  Kokkos::parallel_scan(
      "drench::cell_table::scan", Range(0, t.buckets + 1), KOKKOS_LAMBDA(const Index k, Index& sum, const bool last) {
        const Index n = cursor(k);
        if (last) {
          start(k) = sum;
          cursor(k) = sum;
        }
        sum += n;
      });
  // The order within a bucket depends on timing; the table sorts it.
  parallel(
      "drench::cell_table::scatter", count, KOKKOS_LAMBDA(const Index i) {
        const Index slot = Kokkos::atomic_fetch_add(&cursor(bucket(i)), 1);
        item(slot) = i;
      });
}

class CountingSort final : public BucketSort {
 public:
  void make_keys(CellTableView& table, const Array<Real3>& points, Index count) override {
    if (bucket_.extent(0) < table.item.extent(0))
      bucket_ = Array<Index>(Kokkos::ViewAllocateWithoutInitializing("drench::cell_bucket"), table.item.extent(0));
    if (cursor_.extent(0) < table.start.extent(0))
      cursor_ = Array<Index>(Kokkos::ViewAllocateWithoutInitializing("drench::cell_cursor"), table.start.extent(0));
    count_buckets(table, points, count, bucket_, cursor_);
  }
  void sort(CellTableView& table, Index count) override { scan_and_scatter(table, count, bucket_, cursor_); }
  void read_out(CellTableView&, Index) override {}

 private:
  Array<Index> bucket_, cursor_;
};

}  // namespace

std::shared_ptr<BucketSort> make_counting_sort() { return std::make_shared<CountingSort>(); }

std::shared_ptr<BucketSort> make_bucket_sort(SortMethod method) {
  switch (method == SortMethod::automatic ? fastest_sort : method) {
    case SortMethod::radix:
      return make_radix_sort();
    case SortMethod::bitonic:
      return make_bitonic_sort(false);
    case SortMethod::bitonic_naive:
      return make_bitonic_sort(true);
    default:
      return make_counting_sort();
  }
}

}  // namespace drench::kokkos_backend
