// Stage neighbors (src/stages/neighbors.hpp).

#include "primitives/neighbor_list.hpp"
#include "rigid_bodies.hpp"

namespace drench::kokkos_backend {

void neighbors(Device& d, const StepInfo&, StepReport&) {
  const Real h = d.support;
  d.fluid_cells.build(d.fluid.position, d.fluid.count, h, d.fluid.id);
  build_neighbor_list(d.fluid_fluid, d.fluid.position, d.fluid.count, d.fluid_cells.view(), h, true);
  if (d.boundary.count > 0) {
    if (d.model.has_moving_body() || d.boundary_cells.view().buckets == 0)
      d.boundary_cells.build(d.boundary.position, d.boundary.count, h);
    build_neighbor_list(d.fluid_boundary, d.fluid.position, d.fluid.count, d.boundary_cells.view(), h, false);
    list_body_neighbors(d);
  }
  if (d.samples.count > 0) {
    refresh_samples(d);
    d.sample_cells.build(d.samples.position, d.samples.count, h);
    build_neighbor_list(d.fluid_sample, d.fluid.position, d.fluid.count, d.sample_cells.view(), h, false);
    build_neighbor_list(d.sample_fluid, d.samples.position, d.samples.count, d.fluid_cells.view(), h, false);
    build_neighbor_list(d.sample_sample, d.samples.position, d.samples.count, d.sample_cells.view(), h, true);
  }
}

}  // namespace drench::kokkos_backend
