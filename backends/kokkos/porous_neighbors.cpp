// Stage porous_neighbors (src/stages/porous_neighbors.hpp).

#include "primitives/neighbor_list.hpp"

namespace drench::kokkos_backend {

void porous_neighbors(Device& d, const StepInfo&, StepReport&) {
  const Real h = d.support;
  const bool cloth_moves = d.model.has_moving_cloth();
  refresh_samples(d);
  // Emission and contact wicking ask for samples near samples.
  std::vector<ListRequest> lists;
  if ((d.model.has_fluid() || d.model.has_contact_wicking()) && (cloth_moves || !d.lists_fresh)) {
    d.sample_cells.build(d.samples.position, d.samples.count, h);
    lists.push_back({&d.sample_sample, d.samples.position, d.samples.count, d.sample_cells.view(), true});
  }
  if (d.model.has_exchange()) {
    d.fluid_cells.build(d.fluid.position, d.fluid.count, h, d.fluid.id);
    lists.push_back({&d.fluid_sample, d.fluid.position, d.fluid.count, d.sample_cells.view()});
    lists.push_back({&d.sample_fluid, d.samples.position, d.samples.count, d.fluid_cells.view()});
  }
  if (d.model.has_exchange() && d.model.has_direction() && d.boundary.count > 0 &&
      (cloth_moves || d.model.has_moving_body() || !d.lists_fresh)) {
    if (d.model.has_moving_body() || d.boundary_cells.view().buckets == 0)
      d.boundary_cells.build(d.boundary.position, d.boundary.count, h);
    lists.push_back({&d.sample_boundary, d.samples.position, d.samples.count, d.boundary_cells.view()});
  }
  build_neighbor_lists(lists, h);
  d.lists_fresh = true;
}

}  // namespace drench::kokkos_backend
