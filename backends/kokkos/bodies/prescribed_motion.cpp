// Stage prescribed_motion (src/stages/prescribed_motion.hpp). The host looks up the keys, a few numbers a body.

#include <cmath>

#include "bodies/deforming_body.hpp"
#include "core/host_copy.hpp"
#include "state/keyed_motion.hpp"

namespace drench::kokkos_backend {
namespace {

/// Eqs. 2a, 2b.
RigidState keyed_state(const Body& body, double time, double dt) {
  const Double3 way = to_double(way_at(body, time));
  const drench::Quaternion q = orientation_at(body, time);
  RigidState s;
  s.position = add(to_double(body.center), way);
  s.orientation = {q[0], q[1], q[2], q[3]};
  s.velocity =
      dt > 0 ? times(1 / dt, minus(to_double(way_at(body, time + dt)), way)) : to_double(velocity_at(body, time));
  s.spin = to_double(spin_between(body, time, time + dt));
  return s;
}

}  // namespace

void place_keyed(const Constants& constants, Bodies& bodies, double time, double dt) {
  const Model& m = constants.model;
  if (!m.has_keyed_body()) return;
  std::vector<RigidState> states(m.bodies.size());
  for (std::size_t b = 0; b < m.bodies.size(); ++b)
    if (m.bodies[b].has_keys()) states[b] = keyed_state(m.bodies[b], time, dt);
  if (bodies.keyed.extent(0) != states.size()) bodies.keyed = Array<RigidState>("drench::body_keyed", states.size());
  copy_now(bodies.keyed,
           Kokkos::View<RigidState*, Kokkos::HostSpace, Kokkos::MemoryUnmanaged>(states.data(), states.size()));
}

void prescribed_motion(const Constants& constants, Bodies& bodies, const StepInfo& info) {
  place_keyed(constants, bodies, info.time, info.dt);
  const Entries<const RigidBody> constant = std::as_const(bodies).constant;
  const Entries<const RigidState> keyed = bodies.keyed;
  const Entries<RigidState> state = bodies.state;
  parallel(
      "drench::prescribed_motion::bodies", bodies.count, KOKKOS_LAMBDA(const Index b) {
        if (constant(b).keyed) state(b) = keyed(b);
      });
  const Entries<const Index> of = std::as_const(bodies).boundary.body;
  const Entries<const Real3> x = std::as_const(bodies).boundary.position;
  const Entries<Real3> v = bodies.boundary.velocity, predicted = bodies.dynamic.predicted;
  const bool dynamic = bodies.dynamic.count > 0;
  parallel(
      "drench::prescribed_motion::samples", bodies.boundary.count, KOKKOS_LAMBDA(const Index b) {
        if (!constant(of(b)).keyed) return;
        const RigidState& s = keyed(of(b));
        v(b) = narrow(add(s.velocity, outer(s.spin, minus(widen(x(b)), s.position))));
        if (dynamic) predicted(b) = v(b);
      });
  set_sample_velocities(bodies, info);
}

}  // namespace drench::kokkos_backend
