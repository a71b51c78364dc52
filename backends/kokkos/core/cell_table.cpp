#include "core/cell_table.hpp"

#include <cmath>
#include <utility>

#include "core/bucket_sort.hpp"

namespace drench::kokkos_backend {
namespace {

struct FindBounds {
  using value_type = PointBounds;
  Array<Real3> points;

  KOKKOS_INLINE_FUNCTION void init(PointBounds& b) const { b.clear(); }
  KOKKOS_INLINE_FUNCTION void join(PointBounds& b, const PointBounds& o) const { b.add(o); }
  KOKKOS_INLINE_FUNCTION void operator()(const Index i, PointBounds& b) const { b.add(points(i)); }
};

PointBounds bounds_of(const Array<Real3>& points, Index count, HostBounds& result) {
  make_room_for_one(result, "drench::cell_bounds");
  Kokkos::parallel_reduce("drench::cell_table::bounds", range(count), FindBounds{points}, result);
  exec().fence("drench::cell_table::bounds");
  return result();
}

/// What a bucket is ordered by: the cell, which is one cell unless the table is hashed, and the key.
struct SortKey {
  CellCoord cell;
  std::int64_t key;
  KOKKOS_INLINE_FUNCTION bool operator<(const SortKey& o) const {
    if (cell.z != o.cell.z) return cell.z < o.cell.z;
    if (cell.y != o.cell.y) return cell.y < o.cell.y;
    return cell.x != o.cell.x ? cell.x < o.cell.x : key < o.key;
  }
};
struct SortKeys {
  CellTableView table;
  Array<Real3> points;
  Array<std::int64_t> key;

  KOKKOS_INLINE_FUNCTION SortKey operator()(const Index i) const {
    return {table.hashed ? table.cell_of(points(i)) : CellCoord{0, 0, 0}, key.extent(0) > 0 ? key(i) : i};
  }
};

/// The sort leaves the order within a bucket open: by (cell, key) it is the same in every run and for every sort. A CPU
/// thread sorts a bucket.
void order_buckets(const SortKeys& keys) {
  parallel(
      "drench::cell_table::order", keys.table.buckets, KOKKOS_LAMBDA(const Index k) {
        const CellTableView& t = keys.table;
        const Index first = t.start(k), last = t.start(k + 1);
        for (Index e = first; e < last; ++e) {
          const Index i = t.item(e);
          const SortKey at = keys(i);
          Index slot = e;
          for (; slot > first && at < keys(t.item(slot - 1)); --slot) t.item(slot) = t.item(slot - 1);
          t.item(slot) = i;
        }
      });
}

/// The same on a GPU, where most buckets would be threads with nothing to do: a thread counts what of its bucket is
/// before its entry, and copies the point where it belongs.
void order_entries(const SortKeys& keys, Index count, const Array<Index>& ordered) {
  parallel(
      "drench::cell_table::order", count, KOKKOS_LAMBDA(const Index e) {
        const CellTableView& t = keys.table;
        const Index i = t.item(e);
        const Real3 x = keys.points(i);
        const Index k = bucket_of_point(t, x);
        const SortKey at = keys(i);
        const Index first = t.start(k), last = t.start(k + 1);
        Index slot = first;
        for (Index f = first; f < last; ++f) slot += keys(t.item(f)) < at ? 1 : 0;
        ordered(slot) = i;
        t.point.set(slot, x);
        if (t.hashed) t.coord(slot) = at.cell;
      });
}

void copy_points(const CellTableView& t, const Array<Real3>& points, Index count) {
  parallel(
      "drench::cell_table::points", count, KOKKOS_LAMBDA(const Index e) {
        const Real3 x = points(t.item(e));
        t.point.set(e, x);
        if (t.hashed) t.coord(e) = t.cell_of(x);
      });
}

}  // namespace

PointBounds find_bounds(const Array<Real3>& points, Index count) {
  PointBounds b;
  b.clear();
  if (count == 0) return b;
  HostBounds result;
  return bounds_of(points, count, result);
}

void CellTable::build(const Array<Real3>& points, Index count, Real edge, const Array<std::int64_t>& key,
                      const PointBounds* bounds, std::int64_t all) {
  make_keys(points, count, edge, bounds, all);
  sort();
  make_table(points, key);
}

void CellTable::make_keys(const Array<Real3>& points, Index count, Real edge, const PointBounds* bounds,
                          std::int64_t all) {
  count_ = count;
  if (count > capacity_) {
    capacity_ = count + count / 4;
    make_room(view_.item, "drench::cell_item", static_cast<std::size_t>(capacity_));
    view_.point.allocate(capacity_);
  }
  view_.buckets = 0;
  if (count == 0) return;

  PointBounds b = bounds ? *bounds : bounds_of(points, count, bounds_);
  if (!(b.min_x <= b.max_x)) b = PointBounds{};  // nothing finite
  view_.origin = {b.min_x, b.min_y, b.min_z};
  view_.inverse_edge = 1 / edge;
  const auto cells = [&](Real lo, Real hi) { return std::floor((double(hi) - double(lo)) / double(edge)) + 2; };
  const double nx = cells(b.min_x, b.max_x), ny = cells(b.min_y, b.max_y), nz = cells(b.min_z, b.max_z);
  const std::int64_t sized_for = all > 0 ? all : count;
  const double dense_limit = std::fmax(65536.0, 8.0 * static_cast<double>(sized_for));
  view_.hashed = nx * ny * nz > dense_limit ? 1 : 0;
  if (view_.hashed) {
    make_room(view_.coord, "drench::cell_coord", static_cast<std::size_t>(capacity_));
    view_.buckets = 1024;
    while (view_.buckets < 2 * sized_for && view_.buckets < (1 << 29)) view_.buckets *= 2;
    view_.dims = {0, 0, 0};
  } else {
    view_.dims = {static_cast<int>(nx), static_cast<int>(ny), static_cast<int>(nz)};
    view_.buckets = view_.dims.x * view_.dims.y * view_.dims.z;
  }
  if (view_.buckets > bucket_capacity_) {
    bucket_capacity_ = view_.buckets + view_.buckets / 4;
    make_room(view_.start, "drench::cell_start", static_cast<std::size_t>(bucket_capacity_) + 1);
  }
  if (!sort_) sort_ = make_bucket_sort(method_);
  sort_->make_keys(view_, points, count);
}

double cell_table_bytes(double points, double cells, const Sizing& s) {
  if (points <= 0) return 0;
  const bool hashed = !(cells > 0);
  const double point = (s.gpu ? 4 : 3) * s.real, coord = hashed ? sizeof(CellCoord) : 0;
  double bytes = 1.25 * points * ((s.gpu ? 2 : 1) * index_bytes + point + coord);  // item, and ordered_ on a GPU
  bytes += 1.25 * index_bytes * (hashed ? 2 * points : cells);                     // start
  return bytes + sort_bytes(1.25 * points);
}

void CellTable::sort() {
  if (count_ > 0) sort_->sort(view_, count_);
}

void CellTable::make_table(const Array<Real3>& points, const Array<std::int64_t>& key) {
  if (count_ == 0) return;
  sort_->read_out(view_, count_);
  if (on_host) {
    order_buckets({view_, points, key});
    copy_points(view_, points, count_);
    return;
  }
  make_room(ordered_, "drench::cell_ordered", view_.item.extent(0));
  order_entries({view_, points, key}, count_, ordered_);
  std::swap(view_.item, ordered_);
}

}  // namespace drench::kokkos_backend
