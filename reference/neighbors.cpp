// Stage neighbors (src/stages/neighbors.hpp).

#include <cmath>

#include "neighbor_search.hpp"
#include "sheets.hpp"

namespace drench::reference {
namespace {

using Eigen::Vector3d;

/// The sheet at sample p between a and b.
bool sheet_between(const ReferenceState& state, Index p, const Vector3d& sample, const Vector3d& normal,
                   const Vector3d& a, const Vector3d& b) {
  const double height_a = normal.dot(a - sample), height_b = normal.dot(b - sample);
  if (std::signbit(height_a + 0.0) == std::signbit(height_b + 0.0)) return false;
  const double along = height_a / (height_a - height_b);
  return on_sheet(state, p, (1 - along) * a + along * b);
}

/// Pairs on different sides of a cloth are no neighbours.
void cull_pairs_across_cloth(ReferenceState& state, const Vectors& fluid, const Vectors& samples) {
  const auto apart = [&](Index i, Index j) {
    const Index p = nearest_sample(state, i);
    return p >= 0 && sheet_between(state, p, samples[p], sample_normal(state, p), fluid[i], fluid[j]);
  };
  for (Index i = 0; i < static_cast<Index>(fluid.size()); ++i) {
    std::erase_if(state.fluid_fluid[i], [&](Index j) { return apart(i, j) || apart(j, i); });
  }
}

}  // namespace

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
  if (!state.model.scene.through_cloth) cull_pairs_across_cloth(state, fluid, samples);
}

}  // namespace drench::reference
