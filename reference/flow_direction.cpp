// Stage flow_direction of the oracle; the law stands in src/stages/flow_direction.hpp.

#include "transfer.hpp"

namespace drench::reference {

void flow_direction(ReferenceState& state, const StepInfo&, StepReport&) {
  const Model& m = state.model;
  const Smoothing w(m);
  const Eigen::Vector3d gravity = vec(m.scene.gravity);
  for (Index p = 0; p < m.samples.count(); ++p) {
    state.s.sample_flow_direction[p] = {0, 0, 0};
    if (!is_porous(state, p)) continue;
    const double strength = m.cloths[m.samples.cloth[p]].virtual_pressure;
    const Eigen::Vector3d x = sample_position(state, p);
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();  // Σ_b V_b ∇W_pb, 1/m
    for (const Index b : state.sample_boundary[p]) {
      sum += state.s.boundary_volume[b] * w.gradient(x - vec(state.s.boundary_position[b]));
    }
    const Eigen::Vector3d drive = -strength * m.support * sum + gravity;
    const double epsilon = 1e-3 * (gravity.norm() > 0 ? gravity.norm() : strength);
    if (drive.norm() > 0) state.s.sample_flow_direction[p] = arr(drive / (drive.norm() + epsilon));
  }
}

}  // namespace drench::reference
