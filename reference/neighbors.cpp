// Stage neighbors (src/stages/neighbors.hpp).

#include "neighbor_search.hpp"

namespace drench::reference {

void neighbors(ReferenceState& state, const StepInfo&, StepReport&) {
  const double h = state.model.support;
  const Vectors fluid = vectors(state.s.fluid_position);
  const Vectors boundary = vectors(state.s.boundary_position);
  const Vectors samples = sample_positions(state);
  const SortedCells fluid_cells(fluid, h, state.s.fluid_id);
  const SortedCells boundary_cells(boundary, h);
  const SortedCells sample_cells(samples, h);
  state.fluid_fluid = fluid_cells.around(fluid, true);
  state.fluid_boundary = boundary_cells.around(fluid, false);
  state.fluid_sample = sample_cells.around(fluid, false);
  state.sample_fluid = fluid_cells.around(samples, false);
  state.sample_sample = sample_cells.around(samples, true);
}

}  // namespace drench::reference
