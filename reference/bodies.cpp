// Stage bodies (src/stages/bodies.hpp).

#include <Eigen/Geometry>

#include "common.hpp"

namespace drench::reference {

using Eigen::Vector3d;

void bodies(ReferenceState& state, const StepInfo& info, StepReport&) {
  const BoundarySet& boundary = state.model.boundary;
  const double time = info.time + info.dt;
  for (Index b = 0; b < boundary.count(); ++b) {
    const Body& body = state.model.bodies[boundary.body[b]];
    if (body.spin_rate == 0) {
      state.s.boundary_velocity[b] = {0, 0, 0};
      continue;
    }
    const Vector3d axis = vec(body.spin_axis), center = vec(body.center);
    const Vector3d arm = Eigen::AngleAxisd(body.spin_rate * time, axis) * (vec(boundary.position[b]) - center);
    state.s.boundary_position[b] = arr(center + arm);
    state.s.boundary_velocity[b] = arr((body.spin_rate * axis).cross(arm));
  }
}

}  // namespace drench::reference
