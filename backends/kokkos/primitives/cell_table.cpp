#include "primitives/cell_table.hpp"

#include <cmath>

#include "primitives/bucket_sort.hpp"

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
  if (result.data() == nullptr) result = HostBounds(Kokkos::ViewAllocateWithoutInitializing("drench::cell_bounds"));
  Kokkos::parallel_reduce("drench::cell_table::bounds", Range(0, count), FindBounds{points}, result);
  ExecSpace().fence("drench::cell_table::bounds");
  return result();
}

/// The sort leaves the order within a bucket open: by (cell, key) it is the same in every run and for every sort.
void order_buckets(const CellTableView& t, const Array<Real3>& points, const Array<std::int64_t>& key) {
  const bool keyed = key.extent(0) > 0;
  parallel(
      "drench::cell_table::order", t.buckets, KOKKOS_LAMBDA(const Index k) {
        const Index first = t.start(k), last = t.start(k + 1);
        for (Index e = first; e < last; ++e) {
          const Index i = t.item(e);
          const CellCoord c = t.hashed ? t.cell_of(points(i)) : CellCoord{0, 0, 0};
          const std::int64_t ki = keyed ? key(i) : i;
          Index slot = e;
          while (slot > first) {
            const Index j = t.item(slot - 1);
            const CellCoord o = t.hashed ? t.coord(slot - 1) : CellCoord{0, 0, 0};
            const std::int64_t kj = keyed ? key(j) : j;
            const bool after = c.z != o.z ? c.z > o.z : c.y != o.y ? c.y > o.y : c.x != o.x ? c.x > o.x : ki > kj;
            if (after) break;
            t.item(slot) = j;
            t.coord(slot) = o;
            --slot;
          }
          t.item(slot) = i;
          t.coord(slot) = c;
        }
      });
}

void copy_points(const CellTableView& t, const Array<Real3>& points, Index count) {
  parallel(
      "drench::cell_table::points", count, KOKKOS_LAMBDA(const Index e) { t.point.set(e, points(t.item(e))); });
}

}  // namespace

void CellTable::build(const Array<Real3>& points, Index count, Real edge, const Array<std::int64_t>& key,
                      const PointBounds* bounds) {
  make_keys(points, count, edge, bounds);
  sort();
  make_table(points, key);
}

void CellTable::make_keys(const Array<Real3>& points, Index count, Real edge, const PointBounds* bounds) {
  count_ = count;
  if (count > capacity_) {
    capacity_ = count + count / 4;
    view_.item = Array<Index>(Kokkos::ViewAllocateWithoutInitializing("drench::cell_item"), capacity_);
    view_.coord = Array<CellCoord>(Kokkos::ViewAllocateWithoutInitializing("drench::cell_coord"), capacity_);
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
  const double dense_limit = std::fmax(65536.0, 8.0 * count);
  view_.hashed = nx * ny * nz > dense_limit ? 1 : 0;
  if (view_.hashed) {
    view_.buckets = 1024;
    while (view_.buckets < 2 * static_cast<std::int64_t>(count) && view_.buckets < (1 << 29)) view_.buckets *= 2;
    view_.dims = {0, 0, 0};
  } else {
    view_.dims = {static_cast<int>(nx), static_cast<int>(ny), static_cast<int>(nz)};
    view_.buckets = view_.dims.x * view_.dims.y * view_.dims.z;
  }
  if (view_.buckets > bucket_capacity_) {
    bucket_capacity_ = view_.buckets + view_.buckets / 4;
    view_.start = Array<Index>(Kokkos::ViewAllocateWithoutInitializing("drench::cell_start"), bucket_capacity_ + 1);
  }
  if (!sort_) sort_ = make_bucket_sort(method_);
  sort_->make_keys(view_, points, count);
}

void CellTable::sort() {
  if (count_ > 0) sort_->sort(view_, count_);
}

void CellTable::make_table(const Array<Real3>& points, const Array<std::int64_t>& key) {
  if (count_ == 0) return;
  sort_->read_out(view_, count_);
  order_buckets(view_, points, key);
  copy_points(view_, points, count_);
}

}  // namespace drench::kokkos_backend
