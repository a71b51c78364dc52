// Stage bodies (src/stages/bodies.hpp).

#include <cmath>

#include "device.hpp"

namespace drench::kokkos_backend {

void bodies(Device& d, const StepInfo& info, StepReport&) {
  const double t = info.time + info.dt;
  const auto rest = d.boundary.rest_position, x = d.boundary.position, v = d.boundary.velocity;
  for (const Body& body : d.model.bodies) {
    if (body.spin_rate == 0) continue;
    const Real3 k{Real(body.spin_axis[0]), Real(body.spin_axis[1]), Real(body.spin_axis[2])};
    const Real3 c{Real(body.center[0]), Real(body.center[1]), Real(body.center[2])};
    const Real sine = Real(std::sin(body.spin_rate * t)), cosine = Real(std::cos(body.spin_rate * t));
    const Real speed = Real(body.spin_rate);
    const Index first = body.first_sample;
    // Rodrigues' rotation from the positions at t = 0.
    parallel(
        "drench::bodies::spin", body.sample_count, KOKKOS_LAMBDA(const Index s) {
          const Index b = first + s;
          const Real3 r = rest(b) - c;
          const Real3 rotated = cosine * r + sine * cross(k, r) + ((1 - cosine) * dot(k, r)) * k;
          x(b) = c + rotated;
          v(b) = speed * cross(k, rotated);
        });
  }
}

}  // namespace drench::kokkos_backend
