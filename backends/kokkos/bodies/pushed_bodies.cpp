// Dynamic bodies that cloth pushes (docs/theory/bodies.md, Reaction of cloth).

#include "bodies/pushed_bodies.hpp"

#include "core/host_copy.hpp"

namespace drench::kokkos_backend {

void clear_pushes(Bodies& bodies) {
  allocate_zeros(bodies.dynamic.pushed, "drench::body_pushed", 6 * static_cast<std::size_t>(bodies.count));
  const Entries<std::int64_t> sum = bodies.dynamic.pushed;
  parallel(
      "drench::bodies::clear_pushes", 6 * bodies.count, KOKKOS_LAMBDA(const Index k) { sum(k) = 0; });
}

std::vector<Wrench> pushes_on(const Constants& constants, const Bodies& bodies) {
  const double unit = constants.quantum / impulse_steps;
  const auto units = to_host<std::int64_t>(bodies.dynamic.pushed, 6 * bodies.count);
  std::vector<Wrench> pushes;
  for (std::size_t k = 0; k < units.size(); k += 6) {
    const auto part = [&](std::size_t a) { return unit * double(units[k + a]); };
    pushes.push_back({{part(0), part(1), part(2)}, {part(3), part(4), part(5)}});
  }
  return pushes;
}

RigidState pushed(const RigidBody& body, const RigidState& state, const Wrench& impulse) {
  RigidState end = state;
  if (body.dynamic == 0) return end;
  end.velocity = add(end.velocity, times(body.inverse_mass, impulse.force));
  end.spin = add(end.spin, over_inertia(body, state.orientation, impulse.torque));
  return end;
}

void set_states(Bodies& bodies, const std::vector<RigidState>& states) {
  copy_to_device<RigidState>(bodies.state, states);
  refresh_dynamic_samples(bodies);
}

}  // namespace drench::kokkos_backend
