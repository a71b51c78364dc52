// Stage time_step (src/stages/time_step.hpp).

#include <algorithm>

#include "common.hpp"

namespace drench::reference {

void time_step(ReferenceState& state, const StepInfo&, StepReport& report) {
  const TimeScene& time = state.model.scene.time;
  state.s.node_pin_force.assign(state.s.node_position.size(), Vec3{0, 0, 0});
  report.dt_wanted = time.step;
  if (time.mode == TimeMode::fixed) return;

  const double gravity_gain = vec(state.model.scene.gravity).norm() * time.step;
  double fastest = 0;
  for (const Vec3& v : state.s.fluid_velocity) fastest = std::max(fastest, vec(v).norm() + gravity_gain);
  for (const Vec3& v : state.s.node_velocity) fastest = std::max(fastest, vec(v).norm());
  for (Index k = 0; k < state.s.body_count(); ++k) {
    const Body& body = state.model.bodies[k];
    if (!body.moves()) continue;
    const double turning = vec(state.s.body_angular_velocity[k]).norm() * body.reach;
    fastest = std::max(fastest, vec(state.s.body_velocity[k]).norm() + turning + (body.dynamic ? gravity_gain : 0));
  }
  if (fastest > 0) report.dt_wanted = std::min(time.step, time.cfl * state.model.spacing / fastest);
  report.dt_wanted = std::max(report.dt_wanted, time.step / 1000);
}

}  // namespace drench::reference
