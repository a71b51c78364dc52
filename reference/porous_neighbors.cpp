// Stage porous_neighbors (src/stages/porous_neighbors.hpp).

#include "neighbor_search.hpp"

namespace drench::reference {

void porous_neighbors(ReferenceState& state, const StepInfo&, StepReport&) {
  const double h = state.model.support;
  const Vectors fluid = vectors(state.s.fluid_position);
  const Vectors samples = sample_positions(state);
  const SortedCells sample_cells(samples, h);
  state.fluid_sample = sample_cells.around(fluid, false);
  state.sample_fluid = SortedCells(fluid, h, state.s.fluid_id).around(samples, false);
  state.sample_sample = sample_cells.around(samples, true);
  state.sample_boundary = SortedCells(vectors(state.s.boundary_position), h).around(samples, false);
}

}  // namespace drench::reference
