// Stage bodies (src/stages/bodies.hpp).

#include "laws/contact.hpp"
#include "rigid_bodies.hpp"

namespace drench::kokkos_backend {
namespace {

constexpr int sweeps = 3;  // over the contacts of a dynamic body

/// Moves a dynamic body out of a solid that it has entered by −`phi` (m) at the point p, and takes its velocity into it.
KOKKOS_INLINE_FUNCTION void stop_at(RigidState& s, const RigidBody& body, const Double3& p, double phi,
                                    const Double3& n, const Double3& surface) {
  const Double3 arm = minus(p, s.position);
  s.position = add(s.position, times(-phi, n));
  const double inward = inner(minus(add(s.velocity, outer(s.spin, arm)), surface), n);
  if (!(inward < 0)) return;
  const Double3 lever = outer(arm, n), answer = over_inertia(body, s.orientation, lever);
  const double impulse = -inward / (body.inverse_mass + inner(lever, answer));  // kg m/s
  s.velocity = add(s.velocity, times(impulse * body.inverse_mass, n));
  s.spin = add(s.spin, times(impulse, answer));
}

/// A dynamic sphere or box against one solid.
KOKKOS_INLINE_FUNCTION void stop_at_solid(RigidState& s, const RigidBody& body, const Solid& solid) {
  const bool sphere = body.kind == 1;
  for (int corner = 0; corner < (sphere ? 1 : 8); ++corner) {
    Double3 p = s.position;
    if (!sphere)
      p = add(p,
              turned(s.orientation, {corner & 1 ? body.half.x : -body.half.x, corner & 2 ? body.half.y : -body.half.y,
                                     corner & 4 ? body.half.z : -body.half.z}));
    const SolidDistance at = solid_distance(solid, narrow(p), Real3{});
    const Double3 n = widen(at.normal);
    const double phi = double(at.phi) - (sphere ? body.radius : 0.0);
    if (!(phi < 0)) continue;
    if (sphere) p = minus(p, times(body.radius, n));
    stop_at(s, body, p, phi, n, widen(surface_velocity(solid, narrow(p), Real3{})));
  }
}

void move_bodies(Device& d, double t, double dt) {
  const auto constant = d.bodies.constant;
  const auto state = d.bodies.state;
  const auto solids = d.solids;
  const Index count = d.bodies.count;
  parallel(
      "drench::bodies::motion", count, KOKKOS_LAMBDA(const Index b) {
        const RigidBody& body = constant(b);
        RigidState s = state(b);
        if (!body.moves) return;
        if (!body.dynamic) {
          s.position = add(body.rest_center, times(t, body.rest_velocity));
          s.orientation = turn_by(times(t, body.rest_spin));
          s.velocity = body.rest_velocity;
          s.spin = body.rest_spin;
          state(b) = s;
          return;
        }
        const Double3 momentum = times_inertia(body, s.orientation, s.spin);
        s = moved(s, dt);
        s.spin = over_inertia(body, s.orientation, momentum);
        for (int sweep = 0; sweep < sweeps; ++sweep)
          for (Index other = 0; other < count; ++other)
            if (!constant(other).dynamic) stop_at_solid(s, body, solids(other));
        state(b) = s;
      });
}

}  // namespace

void bodies(Device& d, const StepInfo& info, StepReport&) {
  place_solids(d, info.dt);
  move_bodies(d, info.time + info.dt, info.dt);
  const auto constant = d.bodies.constant;
  const auto state = d.bodies.state;
  const auto rest = d.boundary.rest_position, x = d.boundary.position, v = d.boundary.velocity;
  const auto predicted = d.bodies.predicted;
  const auto of = d.boundary.body;
  const bool dynamic = d.bodies.samples > 0;
  parallel(
      "drench::bodies::samples", d.boundary.count, KOKKOS_LAMBDA(const Index b) {
        const RigidBody& body = constant(of(b));
        if (!body.moves) return;
        const RigidState& s = state(of(b));
        Double3 own = minus(widen(rest(b)), body.rest_center);
        if (body.slides) {
          const Double3 way =
              minus(minus(body.middle, body.rest_center), turned_back(s.orientation, minus(body.middle, s.position)));
          for (const Double3& step : body.lattice)
            own = minus(own, times(Kokkos::floor(inner(way, step) / inner(step, step) + slide_offset), step));
        }
        const Double3 arm = turned(s.orientation, own);
        x(b) = narrow(add(s.position, arm));
        v(b) = narrow(add(s.velocity, outer(s.spin, arm)));
        if (dynamic) predicted(b) = v(b);
      });
}

}  // namespace drench::kokkos_backend
