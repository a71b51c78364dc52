// Stage time_step (src/stages/time_step.hpp).

#include <algorithm>

#include "state/keyed_motion.hpp"
#include "step/stages.hpp"

namespace drench::kokkos_backend {

void time_step(const Constants& constants, const Fluid& fluid, const Bodies& bodies, Cloth& cloth,
               Cached<StateMeasures>& measured, const StepInfo& info, StepReport& report) {
  const TimeScene& time = constants.model.scene.time;
  const Entries<Real3> pin = cloth.nodes.pin_force;
  parallel(
      "drench::time_step::reset", cloth.nodes.count, KOKKOS_LAMBDA(const Index n) { pin(n) = Real3{}; });
  report.dt_wanted = time.step;
  if (time.mode == TimeMode::error) report.dt_wanted = std::min(time.step, constants.model.capillary_step());
  if (time.mode != TimeMode::cfl) return;
  // The last step's ledger has looked; before the first step nobody has.
  if (!measured.is_of(fluid.particles.moved)) measure(constants, fluid, bodies, cloth, measured);
  double fastest = std::max(measured.fluid_speed, measured.node_speed);
  if (constants.model.has_moving_body())
    fastest = std::max(fastest, fastest_body(bodies, double(norm(constants.gravity)) * time.step));
  fastest = std::max(fastest, fastest_by_keys(constants.model, info.time, info.time + time.step));
  double longest = constants.model.capillary_step();
  if (fastest > 0) longest = std::min(longest, time.cfl * double(constants.spacing) / fastest);
  report.dt_wanted = std::clamp(longest, time.step / 1000, time.step);
}

}  // namespace drench::kokkos_backend
