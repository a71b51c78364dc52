// Stage porous_neighbors (src/stages/porous_neighbors.hpp). The liquid needs no cells here: stages absorption and emission go
// through its particles, and ask for the samples near each.

#include "diffusion.hpp"
#include "primitives/neighbor_list.hpp"

namespace drench::kokkos_backend {

void porous_neighbors(Device& d, const StepInfo&, StepReport&) {
  const Model& m = d.model;
  std::vector<ListRequest> lists;
  if (m.has_exchange() || m.has_contact_wicking()) place_samples(d);
  // Emission and contact wicking ask for samples near samples.
  if (m.has_fluid() || m.has_contact_wicking()) {
    refresh_sample_cells(d);
    if (!d.sample_list_fresh)
      lists.push_back({&d.sample_sample, d.samples.position, d.samples.count, d.sample_cells.view(), true});
    d.sample_list_fresh = true;
  }
  if (m.has_exchange()) lists.push_back({&d.fluid_sample, d.fluid.position, d.fluid.count, d.sample_cells.view()});
  if (m.has_exchange() && m.has_direction() && d.boundary.count > 0 &&
      (m.has_moving_body() || !d.boundary_list_fresh)) {
    if (m.has_moving_body() || d.boundary_cells.view().buckets == 0)
      d.boundary_cells.build(d.boundary.position, d.boundary.count, d.support);
    lists.push_back({&d.sample_boundary, d.samples.position, d.samples.count, d.boundary_cells.view()});
    d.boundary_list_fresh = true;
  }
  // Of the nodes' positions alone: the host has its result after the same wait as the lists'.
  if (m.has_diffusion()) launch_diffusion_rate(d);
  if (build_neighbor_lists(lists, d.support)) d.diffusion_work.rate_waited = true;
}

}  // namespace drench::kokkos_backend
