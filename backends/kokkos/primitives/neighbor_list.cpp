#include "primitives/neighbor_list.hpp"

#include <algorithm>

namespace drench::kokkos_backend {

void build_neighbor_list(NeighborList& list, const Array<Real3>& row_points, Index rows, const CellTableView& table,
                         const Array<Real3>& points, Real support, bool same_set) {
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
    grow(capacity, std::max<Index>(8, static_cast<Index>(list.list.extent(1))));
  }
  const Real h2 = support * support;
  for (;;) {
    const auto count = list.count;
    const auto out = list.list;
    const auto width = static_cast<Index>(out.extent(1));
    Index widest = 0;
    Kokkos::parallel_reduce(
        "drench::neighbors::list", Range(0, rows),
        KOKKOS_LAMBDA(const Index i, Index& most) {
          const Real3 x = row_points(i);
          Index n = 0;
          table.for_near(x, [&](const Index j) {
            const Real3 r = x - points(j);
            if (dot(r, r) < h2 && !(same_set && i == j)) {
              if (n < width) out(i, n) = j;
              ++n;
            }
          });
          count(i) = n;
          most = n > most ? n : most;
        },
        Kokkos::Max<Index>(widest));
    if (widest <= width) return;
    grow(static_cast<Index>(list.count.extent(0)), widest + widest / 4 + 4);
  }
}

}  // namespace drench::kokkos_backend
