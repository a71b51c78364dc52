// Stage neighbors (src/stages/neighbors.hpp).

#include <algorithm>
#include <cmath>

#include "neighbor_search.hpp"

namespace drench::reference {
namespace {

using Eigen::Vector3d;

/// Unit normal of the sample's triangle.
Vector3d sample_normal(const ReferenceState& state, Index p) {
  const auto corner = [&](int k) { return vec(state.s.node_position[sample_node(state, p, k)]); };
  return (corner(1) - corner(0)).cross(corner(2) - corner(0)).normalized();
}

/// Whether c, in the plane of sample p, is beyond the rim of its sheet.
bool beyond_rim(const ReferenceState& state, Index p, const Vector3d& c) {
  if (state.model.samples.rim.empty()) return false;
  struct Near {
    double distance, side;
    Index corner;  // the node that is nearest to c, −1: within the edge
    Vector3d outward;
  };
  std::vector<Near> near;
  for (const Index e : state.model.samples.rim[p]) {
    if (e < 0) continue;
    const auto& nodes = state.model.mesh.rim[e];
    const Vector3d a = vec(state.s.node_position[nodes[0]]), b = vec(state.s.node_position[nodes[1]]),
                   o = vec(state.s.node_position[nodes[2]]), along = b - a;
    const double where = (c - a).dot(along) / along.squaredNorm();
    const Vector3d outward = ((a - o) - (a - o).dot(along) / along.squaredNorm() * along).normalized();
    const Index corner = where <= 0 ? nodes[0] : where >= 1 ? nodes[1] : -1;
    near.push_back({(c - a - std::clamp(where, 0.0, 1.0) * along).norm(), (c - a).dot(outward), corner, outward});
  }
  if (near.empty()) return false;
  if (near.size() == 2 && near[0].corner >= 0 && near[0].corner == near[1].corner)
    return (c - vec(state.s.node_position[near[0].corner])).dot(near[0].outward + near[1].outward) > 0;
  return near[near.size() == 2 && near[1].distance < near[0].distance ? 1 : 0].side > 0;
}

/// The sheet at sample p between a and b.
bool sheet_between(const ReferenceState& state, Index p, const Vector3d& sample, const Vector3d& normal,
                   const Vector3d& a, const Vector3d& b) {
  const double height_a = normal.dot(a - sample), height_b = normal.dot(b - sample);
  if (std::signbit(height_a + 0.0) == std::signbit(height_b + 0.0)) return false;
  const double along = height_a / (height_a - height_b);
  const Vector3d c = (1 - along) * a + along * b;
  return (c - sample).norm() < 1.25 * state.model.spacing && !beyond_rim(state, p, c);
}

/// Pairs on different sides of a cloth are no neighbours.
void part_by_cloth(ReferenceState& state, const Vectors& fluid, const Vectors& samples) {
  const auto nearest = [&](Index i) {
    Index best = -1;
    for (const Index p : state.fluid_sample[i]) {
      if (best < 0 || (fluid[i] - samples[p]).norm() < (fluid[i] - samples[best]).norm()) best = p;
    }
    return best;
  };
  const auto parted = [&](Index i, Index j) {
    const Index p = nearest(i);
    return p >= 0 && sheet_between(state, p, samples[p], sample_normal(state, p), fluid[i], fluid[j]);
  };
  for (Index i = 0; i < static_cast<Index>(fluid.size()); ++i) {
    std::erase_if(state.fluid_fluid[i], [&](Index j) { return parted(i, j) || parted(j, i); });
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
  if (!state.model.scene.through_cloth) part_by_cloth(state, fluid, samples);
}

}  // namespace drench::reference
