#pragma once
// Neighbour lists from a cell table: one row per particle, widened when a row overflows, never cut short.

#include "device.hpp"

namespace drench::kokkos_backend {

/// Fills `list` with all points of `table` closer than `support` to each of the `rows` row points. When rows and points
/// are the same set (`same_set`), a particle is not its own neighbour. Within a row: order of cells, then the table's
/// order.
void build_neighbor_list(NeighborList& list, const Array<Real3>& row_points, Index rows, const CellTableView& table,
                         Real support, bool same_set);

}  // namespace drench::kokkos_backend
