// Stage bodies (src/stages/bodies.hpp).

#include "bodies/bodies.hpp"

#include "bodies/contact.hpp"
#include "bodies/deforming_body.hpp"
#include "core/host_copy.hpp"

namespace drench::kokkos_backend {
namespace {

constexpr int sweeps = 3;  // over the contacts of a dynamic body with bodies that change their shape

/// Moves a dynamic body out of a solid that it has entered by −`phi` (m) at the point p, and takes its velocity into
/// it.
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
              rotate(s.orientation, {corner & 1 ? body.half.x : -body.half.x, corner & 2 ? body.half.y : -body.half.y,
                                     corner & 4 ? body.half.z : -body.half.z}));
    const SolidDistance at = solid_distance(solid, narrow(p), Real3{});
    const Double3 n = widen(at.normal);
    const double phi = double(at.phi) - (sphere ? body.radius : 0.0);
    if (!(phi < 0)) continue;
    if (sphere) p = minus(p, times(body.radius, n));
    stop_at(s, body, p, phi, n, widen(surface_velocity(solid, narrow(p), Real3{})));
  }
}

/// Bullet knows no surface that changes its shape: spheres and boxes are stopped there one after the other.
void stop_at_deforming(Bodies& bodies) {
  const Entries<const RigidBody> constant = std::as_const(bodies).constant;
  const Entries<const Solid> solids = std::as_const(bodies).solids;
  const Entries<RigidState> state = bodies.state;
  const Index count = bodies.count;
  parallel(
      "drench::bodies::stopped", count, KOKKOS_LAMBDA(const Index b) {
        const RigidBody& body = constant(b);
        if (!body.dynamic || body.kind == 3) return;
        RigidState s = state(b);
        for (int sweep = 0; sweep < sweeps; ++sweep)
          for (Index other = 0; other < count; ++other)
            if (solids(other).surface.nearest != nullptr) stop_at_solid(s, body, solids(other));
        state(b) = s;
      });
}

/// What is prescribed for a body at time t (s) without keys.
KOKKOS_INLINE_FUNCTION RigidState steady(const RigidBody& body, double t) {
  return {add(body.rest_center, times(t, body.rest_velocity)), body.rest_velocity, body.rest_spin,
          rotation_by(times(t, body.rest_spin))};
}

/// Where a body is dynamic: on the host, with contacts and hinges.
void move_dynamic_bodies(Bodies& bodies, const StepInfo& info) {
  const std::vector<RigidState> start = to_host<RigidState>(bodies.state, bodies.count);
  std::vector<RigidState> keyed, end = start;
  if (bodies.keyed.extent(0) > 0) keyed = to_host<RigidState>(bodies.keyed, bodies.count);
  std::vector<RigidMotion> motion;
  for (const RigidState& s : start) motion.push_back(motion_of(s));
  const double t = info.time + info.dt;
  const std::vector<ContactImpulse> contacts = bodies.contacts->advance(motion, info.dt, t, info.correction_share);
  for (std::size_t b = 0; b < end.size(); ++b) {
    const RigidBody& body = bodies.constant_on_host[b];
    bodies.given_by_bodies.push_back({to_double(contacts[b].impulse), to_double(contacts[b].turning)});
    if (!body.moves) continue;
    if (!body.dynamic) {
      end[b] = body.keyed ? keyed[b] : steady(body, t);
      continue;
    }
    RigidState& s = end[b];
    if (contacts[b].touched) s = state_of(motion[b]);
    const Double3 momentum = times_inertia(body, start[b].orientation, s.spin);
    if (!contacts[b].touched) s = moved(s, info.dt);
    s.spin = over_inertia(body, s.orientation, momentum);
  }
  copy_to_device<RigidState>(bodies.state, end);
  if (!bodies.deforming.empty()) stop_at_deforming(bodies);
}

void move_bodies(Bodies& bodies, const StepInfo& info) {
  if (bodies.contacts) return move_dynamic_bodies(bodies, info);
  const double t = info.time + info.dt;
  const Entries<const RigidBody> constant = std::as_const(bodies).constant;
  const Entries<const RigidState> keyed = bodies.keyed;
  const Entries<RigidState> state = bodies.state;
  parallel(
      "drench::bodies::motion", bodies.count, KOKKOS_LAMBDA(const Index b) {
        const RigidBody& body = constant(b);
        if (body.moves) state(b) = body.keyed ? keyed(b) : steady(body, t);
      });
}

}  // namespace

void bodies(const Constants& constants, Bodies& bodies, const StepInfo& info) {
  place_solids(constants, bodies, info);
  place_keyed(constants, bodies, info.time + info.dt, 0);
  move_bodies(bodies, info);
  const Bodies& all = bodies;
  const Entries<const RigidBody> constant = all.constant;
  const Entries<const RigidState> state = all.state;
  const Entries<const Real3> rest = all.boundary.rest_position;
  const Entries<const Index> of = all.boundary.body;
  const Entries<Real3> x = bodies.boundary.position, v = bodies.boundary.velocity, predicted = bodies.dynamic.predicted;
  const bool dynamic = bodies.dynamic.count > 0;
  parallel(
      "drench::bodies::samples", all.boundary.count, KOKKOS_LAMBDA(const Index b) {
        const RigidBody& body = constant(of(b));
        if (!body.moves) return;
        const RigidState& s = state(of(b));
        Double3 own = minus(widen(rest(b)), body.rest_center);
        if (body.slides) {
          const Double3 way =
              minus(minus(body.middle, body.rest_center), rotate_back(s.orientation, minus(body.middle, s.position)));
          for (const Double3& step : body.lattice)
            own = minus(own, times(Kokkos::floor(inner(way, step) / inner(step, step) + slide_offset), step));
        }
        const Double3 arm = rotate(s.orientation, own);
        x(b) = narrow(add(s.position, arm));
        v(b) = narrow(add(s.velocity, outer(s.spin, arm)));
        if (dynamic) predicted(b) = v(b);
      });
  place_deforming_samples(bodies, info.time + info.dt);
  bodies.moved.advance();
  refresh_sample_volumes(constants, bodies);
}

}  // namespace drench::kokkos_backend
