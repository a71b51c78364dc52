#include "core/filled_rows.hpp"

namespace drench::kokkos_backend {

double filled_rows_bytes(double rows, const Sizing& s) { return s.gpu ? 1.25 * rows * index_bytes : 0; }

void find_filled_rows(const NeighborList& list, Index rows, FilledRows& filled) {
  filled.rows = rows;
  if (on_host || rows == 0) return;
  make_ample_room(filled.row, "drench::neighbors::filled", static_cast<std::size_t>(rows));
  if (filled.count.data() == nullptr)
    filled.count =
        Kokkos::View<Index, MemSpace>(Kokkos::ViewAllocateWithoutInitializing("drench::neighbors::filled_count"));
  const Entries<const Index> count = list.count;
  const Entries<Index> row = filled.row;
  Kokkos::parallel_scan(
      "drench::neighbors::filled_rows", range(rows),
      KOKKOS_LAMBDA(const Index i, Index& place, const bool last) {
        if (count(i) == 0) return;
        if (last) row(place) = i;
        ++place;
      },
      filled.count);
}

}  // namespace drench::kokkos_backend
