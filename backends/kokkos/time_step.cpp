// Stage time_step (src/stages/time_step.hpp).

#include <algorithm>

#include "ledger.hpp"
#include "rigid_bodies.hpp"

namespace drench::kokkos_backend {

void time_step(Device& d, const StepInfo&, StepReport& report) {
  const TimeScene& time = d.model.scene.time;
  const auto pin = d.nodes.pin_force;
  parallel(
      "drench::time_step::reset", d.nodes.count, KOKKOS_LAMBDA(const Index n) { pin(n) = Real3{}; });
  report.dt_wanted = time.step;
  if (time.mode != TimeMode::cfl) return;
  // The last step's ledger has looked; before the first step nobody has.
  if (!d.measured.fresh) measure(d);
  double fastest = std::max(d.measured.fluid_speed, d.measured.node_speed);
  if (d.model.has_moving_body()) fastest = std::max(fastest, fastest_body(d, double(norm(d.gravity)) * time.step));
  double longest = d.model.capillary_step();
  if (fastest > 0) longest = std::min(longest, time.cfl * double(d.spacing) / fastest);
  report.dt_wanted = std::clamp(longest, time.step / 1000, time.step);
}

}  // namespace drench::kokkos_backend
