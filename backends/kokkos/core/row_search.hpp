#pragma once
// What the kernels of a neighbour search see (core/neighbor_search.cpp).

#include "core/neighbor_search.hpp"

namespace drench::kokkos_backend {

/// What finds the rows' entries, and where these go.
struct Search {
  Entries<const Real3> row_points;
  Index rows = 0;
  CellTableView table;
  bool same_set = false, in_order = false, compact = false;  // ListRequest
  Real h2 = 0;                                               // m²: the support's square
  Entries<Index> count;
  Entries<std::int64_t> start;
  Slice<Index> entry;
  std::int64_t *used = nullptr, *next_used = nullptr;  // NeighborList
  Kokkos::View<std::int64_t, Kokkos::SharedHostPinnedSpace> needed;

  /// The cells [lo, hi] around a point, without those that a dense table does not have.
  KOKKOS_INLINE_FUNCTION void cells_around(const Real3& x, CellCoord& lo, CellCoord& hi) const {
    const CellCoord c = table.cell_of(x);
    lo = {c.x - 1, c.y - 1, c.z - 1};
    hi = {c.x + 1, c.y + 1, c.z + 1};
    table.clip(lo, hi);
  }
  /// Room for so many entries; −1 if there is not as much.
  KOKKOS_INLINE_FUNCTION std::int64_t take(std::int64_t entries) const {
    const std::int64_t first = Kokkos::atomic_fetch_add(used, entries), end = first + entries;
    if (end <= entry.count) return first;
    Kokkos::atomic_max(&needed(), end);
    return -1;
  }
};

}  // namespace drench::kokkos_backend
