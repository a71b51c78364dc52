// Radix sort of a cell table: the buckets are the keys, and sorted keys say where a bucket starts.

#include "core/bucket_sort.hpp"
#include "core/pair_sort.hpp"

namespace drench::kokkos_backend {
namespace {

using Key = PairSort::Key;

void write_keys(const CellTableView& t, const Array<Real3>& points, Index count, const Array<Key>& key) {
  const auto item = t.item;
  parallel(
      "drench::cell_table::radix_keys", count, KOKKOS_LAMBDA(const Index i) {
        key(i) = static_cast<Key>(bucket_of_point(t, points(i)));
        item(i) = i;
      });
}

class RadixSort final : public BucketSort {
 public:
  void make_keys(CellTableView& table, const Array<Real3>& points, Index count) override {
    make_room(pairs_.key, "drench::cell_radix_key", table.item.extent(0));
    write_keys(table, points, count, pairs_.key);
  }
  void sort(CellTableView& table, Index count) override {
    pairs_.item = table.item;
    sort_pairs(pairs_, count, bits_of_buckets(table.buckets));
    table.item = pairs_.item;
  }
  void read_out(CellTableView& table, Index count) override { find_starts(table, pairs_.key, count); }

 private:
  PairSort pairs_;
};

}  // namespace

std::shared_ptr<BucketSort> make_radix_sort() { return std::make_shared<RadixSort>(); }

}  // namespace drench::kokkos_backend
