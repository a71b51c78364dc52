// Stage time_step (src/stages/time_step.hpp).

#include <algorithm>

#include "device.hpp"
#include "laws/viscosity.hpp"
#include "primitives/reduce.hpp"
#include "rigid_bodies.hpp"

namespace drench::kokkos_backend {

void time_step(Device& d, const StepInfo&, StepReport& report) {
  const TimeScene& time = d.model.scene.time;
  const auto pin = d.nodes.pin_force;
  parallel(
      "drench::time_step::reset", d.nodes.count, KOKKOS_LAMBDA(const Index n) { pin(n) = Real3{}; });
  report.dt_wanted = time.step;
  if (time.mode != TimeMode::cfl) return;
  const auto x = d.fluid.position, v = d.fluid.velocity, vn = d.nodes.velocity;
  const Real3 g = d.gravity, center = d.field_center, square = d.field_square;
  const bool field = d.model.scene.field.present;
  const double step = time.step;
  double fastest = 0;
  if (d.fluid.count > 0)
    fastest = maximum(
        "drench::time_step::fluid_speed", d.fluid.count, KOKKOS_LAMBDA(const Index i) {
          const Real3 a = field ? g + central_field(x(i), center, square) : g;
          return double(norm(v(i))) + double(norm(a)) * step;
        });
  if (d.nodes.count > 0)
    fastest = std::max(fastest, maximum(
                                    "drench::time_step::node_speed", d.nodes.count,
                                    KOKKOS_LAMBDA(const Index n) { return double(norm(vn(n))); }));
  if (d.model.has_moving_body()) fastest = std::max(fastest, fastest_body(d, double(norm(g)) * step));
  double longest = d.model.capillary_step();
  if (fastest > 0) longest = std::min(longest, time.cfl * double(d.spacing) / fastest);
  report.dt_wanted = std::clamp(longest, time.step / 1000, time.step);
}

}  // namespace drench::kokkos_backend
