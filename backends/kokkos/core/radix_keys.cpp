#include "core/radix_keys.hpp"

namespace drench::kokkos_backend {
namespace {

void write_keys(const CellTableView& t, const Array<Real3>& points, Index count, const Array<RadixKeys::Key>& key) {
  const auto item = t.item;
  parallel(
      "drench::cell_table::radix_keys", count, KOKKOS_LAMBDA(const Index i) {
        key(i) = static_cast<RadixKeys::Key>(bucket_of_point(t, points(i)));
        item(i) = i;
      });
}

}  // namespace

void RadixKeys::make_keys(CellTableView& table, const Array<Real3>& points, Index count) {
  const auto n = table.item.extent(0);
  make_room(key_, "drench::cell_radix_key", n);
  make_room(next_key_, "drench::cell_radix_next_key", n);
  make_room(next_item_, "drench::cell_radix_next_item", n);
  write_keys(table, points, count, key_);
}

void RadixKeys::read_out(CellTableView& table, Index count) { find_starts(table, key_, count); }

}  // namespace drench::kokkos_backend
