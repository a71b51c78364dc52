#pragma once
// Rows of a list that have any entries. Few particles are near cloth: kernels over their samples take those alone, by
// lanes.

#include "core/gather.hpp"
#include "core/neighbor_list.hpp"
#include "core/sizing.hpp"

namespace drench::kokkos_backend {

/// Finds them among the first `rows`, in their order; a host's kernels go over all of these.
void find_filled_rows(const NeighborList& list, Index rows, FilledRows& filled);
/// Of a list with so many rows.
double filled_rows_bytes(double rows, const Sizing& s);

/// body(n, lane) for each row n that has any, by all of its lanes (parallel_rows); on a host for every row.
template <class Body>
void parallel_filled_rows(const char* label, const FilledRows& filled, const Body& body) {
  if constexpr (on_host) {
    parallel_rows(label, filled.rows, body);
  } else {
    const Index groups = filled.rows < rows_at_once ? filled.rows : rows_at_once;
    const Entries<const Index> row = filled.row;
    const auto count = filled.count;
    parallel(
        label, groups * row_lanes, KOKKOS_LAMBDA(const Index thread) {
          const Index all = count();
          for (Index k = thread / row_lanes; k < all; k += groups) body(row(k), thread % row_lanes);
        });
  }
}

}  // namespace drench::kokkos_backend
