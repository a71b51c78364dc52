#include "primitives/neighbor_list.hpp"

#include <algorithm>

namespace drench::kokkos_backend {
namespace {

/// Entry n of row i, if it is near; the last column takes what does not count. A CPU is quicker with a store each time than
/// with a branch that it cannot foresee. (A function, not a part of the kernel: nvcc names a kernel after the order in
/// which its lambda captures, which has to be the same on the host and on the device.)
KOKKOS_INLINE_FUNCTION void store(const Kokkos::View<Index**, MemSpace>& list, Index i, Index n, Index width, Index j,
                                  bool near) {
  KOKKOS_IF_ON_HOST((static_cast<void>(near); list(i, n < width ? n : width) = j;))
  KOKKOS_IF_ON_DEVICE((if (near && n < width) list(i, n) = j;))
}

}  // namespace

void build_neighbor_list(NeighborList& list, const Array<Real3>& row_points, Index rows, const CellTableView& table,
                         Real support, bool same_set) {
  list.rows = rows;
  if (rows == 0) return;
  auto grow = [&](Index wanted_rows, Index width) {
    list.list = {};  // free before allocating
    list.list = Kokkos::View<Index**, MemSpace>(Kokkos::ViewAllocateWithoutInitializing("drench::neighbors"),
                                                wanted_rows, width);
  };
  if (rows > static_cast<Index>(list.count.extent(0))) {
    const Index capacity = rows + rows / 4;
    list.count = Array<Index>(Kokkos::ViewAllocateWithoutInitializing("drench::neighbor_count"), capacity);
    grow(capacity, std::max<Index>(9, static_cast<Index>(list.list.extent(1))));
  }
  const Real h2 = support * support;
  for (;;) {
    const auto count = list.count;
    const auto out = list.list;
    const auto width = static_cast<Index>(out.extent(1)) - 1;
    Index widest = 0;
    Kokkos::parallel_reduce(
        "drench::neighbors::list", Range(0, rows),
        KOKKOS_LAMBDA(const Index i, Index& most) {
          const Real3 x = row_points(i);
          const Index self = same_set ? i : Index(-1);
          CellCoord lo = table.cell_of(x), hi = lo;
          lo = {lo.x - 1, lo.y - 1, lo.z - 1};
          hi = {hi.x + 1, hi.y + 1, hi.z + 1};
          Index n = 0;
          if (table.buckets > 0) {
            table.clip(lo, hi);
            table.for_runs(lo, hi, [&](const Index first, const Index last, const CellCoord& c) {
              for (Index e = first; e < last; ++e) {
                const Real3 r = x - table.point(e);
                const Index j = table.item(e);
                bool near = (dot(r, r) < h2) & (j != self);
                if (table.hashed) near = near && table.coord(e) == c;
                store(out, i, n, width, j, near);
                n += near ? 1 : 0;
              }
            });
          }
          count(i) = n;
          most = n > most ? n : most;
        },
        Kokkos::Max<Index>(widest));
    if (widest <= width) return;
    grow(static_cast<Index>(list.count.extent(0)), widest + widest / 4 + 5);
  }
}

}  // namespace drench::kokkos_backend
