// Stage rotating_frame of the reference; the equations are in docs/theory/rotating_frame.md.

#include "stages/rotating_frame.hpp"

#include <numbers>

#include "common.hpp"

namespace drench::reference {

using Eigen::Vector3d;

void rotating_frame(ReferenceState& state, const StepInfo& info, StepReport&) {
  HostState& s = state.s;
  const Model& m = state.model;
  const RotatingFrameScene& frame = m.scene.rotating_frame;
  const double radian = std::numbers::pi / 180, end = info.time + info.dt;
  const Vector3d axis = vec(frame.axis).normalized(), center = vec(frame.center);
  const double angle = radian * frame.degrees_per_second.integral(info.time, end), rate = angle / info.dt;
  const double gained = radian * (frame.degrees_per_second.at(end) - frame.degrees_per_second.at(info.time));
  const Eigen::AngleAxisd turn(-2 * angle, axis);
  // Eq. 2
  const auto changed = [&](const Vec3& position, const Vec3& velocity) -> Vector3d {
    const Vector3d r = vec(position) - center;
    return turn * vec(velocity) - info.dt * rate * rate * axis.cross(axis.cross(r)) - gained * axis.cross(r);
  };
  if (m.has_moving_liquid())
    for (Index i = 0; i < s.fluid_count(); ++i)
      s.fluid_velocity[i] = arr(changed(s.fluid_position[i], s.fluid_velocity[i]));
  if (!m.has_moving_cloth()) return;
  for (Index n = 0; n < s.node_count(); ++n) {
    const Vector3d v = changed(s.node_position[n], s.node_velocity[n]);
    if (m.mesh.is_fixed(n))  // Eq. 3
      s.node_pin_force[n] =
          arr(vec(s.node_pin_force[n]) - node_mass(state, n) / info.dt * (v - vec(s.node_velocity[n])));
    else
      s.node_velocity[n] = arr(v);
  }
}

}  // namespace drench::reference
