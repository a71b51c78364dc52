#pragma once
// Neighbour lists from a cell table: one row per particle, with room for what there is, never cut short.

#include <vector>

#include "core/cell_table.hpp"
#include "core/neighbor_list.hpp"

namespace drench::kokkos_backend {

/// Fills `list` with all points of `table` closer than `support` to each of the `rows` row points. When rows and points
/// are the same set (`same_set`), a particle is not its own neighbour. Within a row: order of cells, then the table's
/// order.
struct ListRequest {
  NeighborList* list;
  const Array<Real3>* row_points;
  Index rows;
  CellTableView table;
  bool same_set = false;
  bool in_order = false;  // the points lie in the order of the table: its item(e) is e
  bool compact = false;   // as CompactRow has them (core/liquid_pairs.hpp)
};
void build_neighbor_list(const ListRequest& request, Real support);
/// Several at once: the host waits once, to see whether there was room. Returns whether it did: there may be no rows.
bool build_neighbor_lists(const std::vector<ListRequest>& requests, Real support);

/// Of a list with so many rows and entries, without what stages keep beside its entries.
double list_bytes(double rows, double entries, const Sizing& s);
/// Of the liquid's own list, with all that stages keep of its pairs.
double liquid_list_bytes(double rows, double entries, const Sizing& s);
/// How many entries a list has room for that has so many.
double room_for_entries(double entries);

/// Each row's entries.
std::vector<std::vector<Index>> rows_on_host(const NeighborList& list);

}  // namespace drench::kokkos_backend
