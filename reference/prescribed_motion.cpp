// Stage prescribed_motion (src/stages/prescribed_motion.hpp).

#include "deforming_body.hpp"
#include "rigid_bodies.hpp"

namespace drench::reference {

void prescribed_motion(ReferenceState& state, const StepInfo& info, StepReport&) {
  const Model& m = state.model;
  for (Index k = 0; k < state.s.body_count(); ++k) {
    const Body& body = m.bodies[k];
    if (!body.has_keys()) continue;
    Pose pose = prescribed_pose(body, info.time);
    const Pose end = prescribed_pose(body, info.time + info.dt);
    pose.velocity = (end.position - pose.position) / info.dt;
    pose.spin = body.spin_rate.integral(info.time, info.time + info.dt) / info.dt * vec(body.spin_axis);
    if (!body.turns.empty() || body.commanded) pose.spin = angular_velocity(pose.orientation, end.orientation, info.dt);
    set_pose(state.s, k, pose);
  }
  for (Index b = 0; b < m.boundary.count(); ++b) {
    if (!m.bodies[m.boundary.body[b]].has_keys()) continue;
    const Pose pose = pose_of(state.s, m.boundary.body[b]);
    state.s.boundary_velocity[b] = arr(pose.velocity_at(vec(state.s.boundary_position[b])));
  }
  move_shape_samples(state, info);
}

}  // namespace drench::reference
