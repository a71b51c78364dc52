// Stage flow_direction of the oracle; the law stands in src/stages/flow_direction.hpp.

#include <algorithm>

#include "transfer.hpp"

namespace drench::reference {

Eigen::Vector3d virtual_pressure(const ReferenceState& state, Index p) {
  const Model& m = state.model;
  const Smoothing w(m);
  const Eigen::Vector3d x = sample_position(state, p);
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();  // Σ_b V_b ∇W_pb, 1/m
  for (const Index b : state.sample_boundary[p])
    sum += state.s.boundary_volume[b] * w.gradient(x - vec(state.s.boundary_position[b]));
  return -m.material_of_sample(p).virtual_pressure * m.support * sum;
}

Eigen::Vector3d normalised_drive(const ReferenceState& state, Index p, const Eigen::Vector3d& pressure) {
  const Model& m = state.model;
  const Eigen::Vector3d gravity = vec(m.scene.gravity), drive = pressure + gravity;
  const double epsilon = 1e-3 * (gravity.norm() > 0 ? gravity.norm() : m.material_of_sample(p).virtual_pressure);
  return drive.norm() > 0 ? Eigen::Vector3d(drive / (drive.norm() + epsilon)) : Eigen::Vector3d(0, 0, 0);
}

namespace {

/// P^h: no more of the virtual pressure than gravity calls for.
Eigen::Vector3d held(const Eigen::Vector3d& pressure, const Eigen::Vector3d& gravity) {
  const double g = gravity.norm();
  if (pressure.norm() == 0 || g == 0) return pressure;
  const Eigen::Vector3d n = pressure.normalized();
  const double tangential = (gravity - gravity.dot(n) * n).norm();
  return n * std::min(pressure.norm(), std::max(0.0, -gravity.dot(n)) + std::max(0.0, 0.25 * g - tangential));
}

}  // namespace

void flow_direction(ReferenceState& state, const StepInfo&, StepReport&) {
  for (Index p = 0; p < state.model.samples.count(); ++p) {
    state.s.sample_flow_direction[p] = {0, 0, 0};
    if (!is_porous(state, p)) continue;
    const Eigen::Vector3d pressure = held(virtual_pressure(state, p), vec(state.model.scene.gravity));
    state.s.sample_flow_direction[p] = arr(normalised_drive(state, p, pressure));
  }
}

}  // namespace drench::reference
