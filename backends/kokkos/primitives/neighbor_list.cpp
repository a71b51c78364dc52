#include "primitives/neighbor_list.hpp"

#include <algorithm>
#include <cstring>

namespace drench::kokkos_backend {
namespace {

/// Row i of a list while it is filled; what does not fit is counted only.
struct Row {
  Kokkos::View<Index**, MemSpace> list;
  Index i, width, count;  // the column `width` is there to be overwritten
  bool in_order;          // ListRequest
};

/// As many numbers as a vector register of the machine that is compiled for holds.
#if defined(__AVX512F__)
constexpr int register_bytes = 64;
#elif defined(__AVX__)
constexpr int register_bytes = 32;
#else
constexpr int register_bytes = 16;
#endif
using Lot [[gnu::vector_size(register_bytes)]] = Real;
constexpr Index lot_size = register_bytes / sizeof(Real);
static_assert(lot_size <= PointLanes::spare);

/// Appends what is near of the table's entries [first, last): a CPU computes distances in vector registers, and stores each
/// entry, which is quicker than a branch that it cannot foresee. The table's points end in a lot of spare ones.
[[maybe_unused]] inline void append_near(Row& row, const CellTableView& table, const PointLanes& points, Index first,
                                         Index last, const CellCoord& cell, const Real3& x, Real h2, Index self) {
  const Real *px = points.x.data(), *py = points.y.data(), *pz = points.z.data();
  const Index* const item = table.item.data();
  Index* const out = &row.list(row.i, 0);
  Index n = row.count;
  for (Index e = first; e < last; e += lot_size) {
    Lot rx, ry, rz;
    std::memcpy(&rx, px + e, sizeof(Lot));
    std::memcpy(&ry, py + e, sizeof(Lot));
    std::memcpy(&rz, pz + e, sizeof(Lot));
    rx = x.x - rx;
    ry = x.y - ry;
    rz = x.z - rz;
    const auto near = rx * rx + ry * ry + rz * rz < h2;  // −1 or 0
    const Index most = last - e < lot_size ? last - e : lot_size;
    for (Index k = 0; k < most; ++k) {
      const Index j = item[e + k];
      Index one = static_cast<Index>(near[k]) & (j != self ? -1 : 0);
      if (table.hashed) one = table.coord(e + k) == cell ? one : 0;
      out[n < row.width ? n : row.width] = j;
      n -= one;
    }
  }
  row.count = n;
}

/// The same by a GPU thread. (A function, not a part of the kernel: nvcc names a kernel after the order in which its lambda
/// captures, which has to be the same on the host and on the device.)
KOKKOS_INLINE_FUNCTION void append_near(Row& row, const CellTableView& table, const PackedPoints& points, Index first,
                                        Index last, const CellCoord& cell, const Real3& x, Real h2, Index self) {
  if (row.in_order && !table.hashed) {  // the fluid among itself: an entry is its particle
    DRENCH_UNROLL
    for (Index e = first; e < last; ++e) {
      const Real3 r = x - points(e);
      if (dot(r, r) < h2 && e != self) {
        if (row.count < row.width) row.list(row.i, row.count) = e;
        ++row.count;
      }
    }
    return;
  }
  for (Index e = first; e < last; ++e) {
    const Real3 r = x - points(e);
    if (!(dot(r, r) < h2)) continue;
    const Index j = table.item(e);
    if (j == self || (table.hashed && !(table.coord(e) == cell))) continue;
    if (row.count < row.width) row.list(row.i, row.count) = j;
    ++row.count;
  }
}

void grow(NeighborList& list, Index rows, Index width) {
  list.list = {};  // free before allocating
  list.list =
      Kokkos::View<Index**, MemSpace>(Kokkos::ViewAllocateWithoutInitializing("drench::neighbors"), rows, width);
}

void make_room(NeighborList& list, Index rows) {
  list.rows = rows;
  if (list.longest.data() == nullptr)
    list.longest = Kokkos::View<Index, Kokkos::SharedHostPinnedSpace>("drench::neighbors::longest");
  if (rows <= static_cast<Index>(list.count.extent(0))) return;
  const Index capacity = rows + rows / 4;
  list.count = Array<Index>(Kokkos::ViewAllocateWithoutInitializing("drench::neighbor_count"), capacity);
  grow(list, capacity, std::max<Index>(9, static_cast<Index>(list.list.extent(1))));
}

void fill(const ListRequest& request, Real support) {
  NeighborList& list = *request.list;
  const auto row_points = request.row_points;
  const CellTableView table = request.table;
  const bool same_set = request.same_set, in_order = request.in_order;
  const Real h2 = support * support;
  const auto count = list.count;
  const auto out = list.list;
  const auto longest = list.longest;
  const auto width = static_cast<Index>(out.extent(1)) - 1;
  longest() = 0;
  parallel(
      "drench::neighbors::list", list.rows, KOKKOS_LAMBDA(const Index i) {
        const Real3 x = row_points(i);
        const Index self = same_set ? i : Index(-1);
        CellCoord lo = table.cell_of(x), hi = lo;
        lo = {lo.x - 1, lo.y - 1, lo.z - 1};
        hi = {hi.x + 1, hi.y + 1, hi.z + 1};
        Row row{out, i, width, 0, in_order};
        if (table.buckets > 0) {
          table.clip(lo, hi);
          table.for_runs(lo, hi, [&](const Index first, const Index last, const CellCoord& c) {
            append_near(row, table, table.point, first, last, c, x, h2, self);
          });
        }
        count(i) = row.count;
        if (row.count > width) Kokkos::atomic_max(&longest(), row.count);
      });
}

}  // namespace

void build_neighbor_list(const ListRequest& request, Real support) { build_neighbor_lists({request}, support); }

bool build_neighbor_lists(const std::vector<ListRequest>& requests, Real support) {
  std::vector<ListRequest> left;
  for (const ListRequest& request : requests) {
    request.list->rows = request.rows;
    if (request.rows == 0) continue;
    make_room(*request.list, request.rows);
    left.push_back(request);
  }
  const bool waits = !left.empty();
  while (!left.empty()) {
    for (const ListRequest& request : left) fill(request, support);
    ExecSpace().fence("drench::neighbors::list");
    std::erase_if(left, [](const ListRequest& request) { return request.list->longest() == 0; });
    for (const ListRequest& request : left) {
      const Index widest = request.list->longest();
      grow(*request.list, static_cast<Index>(request.list->count.extent(0)), widest + widest / 4 + 5);
    }
  }
  return waits;
}

}  // namespace drench::kokkos_backend
