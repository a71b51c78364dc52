// Counting sort: histogram, exclusive scan, scatter. The scan's result is the table's `start`.

#include "core/bucket_sort.hpp"

namespace drench::kokkos_backend {
namespace {

void clear(const Array<Index>& a, Index n) {
  if (!on_host) {
    Kokkos::deep_copy(exec(), Kokkos::subview(a, Kokkos::make_pair(Index(0), n)), Index(0));
    return;
  }
  parallel(
      "drench::cell_table::clear", n, KOKKOS_LAMBDA(const Index k) { a(k) = 0; });
}

// What is counted of bucket k stands at start(k + 1): after the scan that is where the bucket starts, and when all its
// particles are in, where the next one does.

void count_buckets(const CellTableView& t, const Array<Real3>& points, Index count, const Array<Index>& bucket) {
  clear(t.start, t.buckets + 1);
  parallel(
      "drench::cell_table::count", count, KOKKOS_LAMBDA(const Index i) {
        const Index k = bucket_of_point(t, points(i));
        bucket(i) = k;
        Kokkos::atomic_inc(&t.start(k + 1));
      });
}

void scatter(const CellTableView& t, Index count, const Array<Index>& bucket) {
  const auto start = t.start, item = t.item;
  // The order within a bucket depends on timing; the table sorts it.
  parallel(
      "drench::cell_table::scatter", count, KOKKOS_LAMBDA(const Index i) {
        const Index slot = Kokkos::atomic_fetch_add(&start(bucket(i) + 1), 1);
        item(slot) = i;
      });
}

class CountingSort final : public BucketSort {
 public:
  void make_keys(CellTableView& table, const Array<Real3>& points, Index count) override {
    make_room(bucket_, "drench::cell_bucket", table.item.extent(0));
    count_buckets(table, points, count, bucket_);
  }
  void sort(CellTableView& table, Index count) override {
    sums_.sum(table.start, table.buckets + 1);
    scatter(table, count, bucket_);
  }
  void read_out(CellTableView&, Index) override {}

 private:
  Array<Index> bucket_;
  PrefixSums sums_;
};

}  // namespace

double sort_bytes(double room) { return room * index_bytes; }  // bucket

#ifndef KOKKOS_ENABLE_CUDA
void PrefixSums::sum(const Array<Index>& a, Index n) {
  Kokkos::parallel_scan(
      "drench::cell_table::scan", range(n), KOKKOS_LAMBDA(const Index k, Index& sum, const bool last) {
        const Index here = a(k);
        if (last) a(k) = sum;
        sum += here;
      });
}
#endif

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
