// Stage rotating_frame (src/stages/rotating_frame.hpp).

#include <cmath>
#include <numbers>

#include "core/host_copy.hpp"
#include "core/kernel.hpp"
#include "coupling/forcing.hpp"

namespace drench::kokkos_backend {
namespace {

/// What the frame does to velocities in one step.
struct Turning {
  Real3 axis, center;
  Real sine, versine;    // of −2Δθ: sin, 1 − cos
  Real outward, gained;  // Δt Ω², 1/s, and the change of Ω, rad/s

  Turning(const RotatingFrameScene& frame, const StepInfo& info) : center(to_real(frame.center)) {
    const double radian = std::numbers::pi / 180, end = info.time + info.dt;
    const double length = std::hypot(frame.axis[0], frame.axis[1], frame.axis[2]);
    axis = to_real({frame.axis[0] / length, frame.axis[1] / length, frame.axis[2] / length});
    const double angle = radian * frame.degrees_per_second.integral(info.time, end);
    sine = Real(-std::sin(2 * angle));
    versine = Real(2 * std::sin(angle) * std::sin(angle));
    outward = Real(angle * angle / info.dt);
    gained = Real(radian * (frame.degrees_per_second.at(end) - frame.degrees_per_second.at(info.time)));
  }

  /// Eq. 2: the change of the velocity v at x, m/s.
  KOKKOS_INLINE_FUNCTION Real3 change(const Real3& x, const Real3& v) const {
    const Real3 across = cross(axis, x - center), turned = cross(axis, v);
    return sine * turned + versine * cross(axis, turned) - outward * cross(axis, across) - gained * across;
  }
};

void turn_liquid(const Turning& turning, Fluid& fluid) {
  const Entries<const Real3> x = fluid.particles.position;
  const Entries<Real3> velocity = fluid.particles.velocity;
  parallel(
      "drench::rotating_frame::liquid", fluid.particles.count,
      KOKKOS_LAMBDA(const Index i) { velocity(i) += turning.change(x(i), velocity(i)); });
}

void turn_cloth(const Turning& turning, const Constants& constants, Cloth& cloth, Real dt) {
  const Entries<const Real3> x = cloth.nodes.position;
  const Entries<Real3> velocity = cloth.nodes.velocity, pin_force = cloth.nodes.pin_force;
  const Entries<const Real> solid = cloth.nodes.solid_mass;
  const Entries<const Quanta> liquid = cloth.nodes.liquid;
  const Entries<const std::uint8_t> fixed = cloth.nodes.fixed;
  const Real quantum = Real(constants.quantum);
  parallel(
      "drench::rotating_frame::cloth", cloth.nodes.count, KOKKOS_LAMBDA(const Index n) {
        const Real3 change = turning.change(x(n), velocity(n));
        if (fixed(n))  // Eq. 3
          pin_force(n) -= (solid(n) + quantum * Real(liquid(n))) / dt * change;
        else
          velocity(n) += change;
      });
}

}  // namespace

MemoryEstimate rotating_frame_bytes(const Sizing&) { return {}; }

void rotating_frame(const Forcing& on) {
  const Turning turning(on.constants.model.scene.rotating_frame, on.info);
  if (on.constants.model.has_moving_liquid()) turn_liquid(turning, on.fluid);
  if (on.constants.model.has_moving_cloth()) turn_cloth(turning, on.constants, on.cloth, Real(on.info.dt));
}

}  // namespace drench::kokkos_backend
