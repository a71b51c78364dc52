#include "coupling/body_response.hpp"

#include "bodies/sample_sums.hpp"
#include "core/host_copy.hpp"
#include "core/neighbor_search.hpp"
#include "coupling/wall.hpp"
#include "particles/viscosity.hpp"

namespace drench::kokkos_backend {

void list_body_neighbors(const Constants& constants, const Fluid& fluid, Bodies& bodies, NeighborLists& lists) {
  DynamicSamples& dynamic = bodies.dynamic;
  if (dynamic.count == 0) return;
  const Entries<const Index> sample = std::as_const(dynamic).sample;
  const Entries<const Real3> x = std::as_const(bodies).boundary.position;
  const Entries<Real3> position = dynamic.position;
  parallel(
      "drench::bodies::sample_position", dynamic.count, KOKKOS_LAMBDA(const Index s) { position(s) = x(sample(s)); });
  build_neighbor_list({&lists.boundary_fluid, &dynamic.position, dynamic.count, fluid.cells.view()}, constants.support);
  fluid.exchange.keep_own_rows(dynamic.position, lists.boundary_fluid);
}

MemoryEstimate body_neighbor_bytes(const Sizing& s) {
  MemoryEstimate sum;
  if (s.size.fluid > 0 && s.size.dynamic_samples > 0)
    sum.lists = list_bytes(s.size.dynamic_samples, s.entries.boundary_fluid, s);
  return sum;
}

namespace {

/// What the kernels over the samples of dynamic bodies see of them and of the liquid near them.
struct WetSamples {
  Neighbors list;
  Kernel kernel;
  Entries<const Index> sample, owner;  // of bodies.boundary; the body
  Entries<const RigidState> state;     // of the bodies
  Entries<const Real3> position, liquid;
  Entries<const Real> own_volume, liquid_volume;

  WetSamples(const Constants& constants, const Fluid& fluid, const NeighborLists& lists, const Bodies& bodies)
      : list(lists.boundary_fluid),
        kernel(constants.kernel),
        sample(bodies.dynamic.sample),
        owner(bodies.dynamic.owner),
        state(bodies.state),
        position(bodies.dynamic.position),
        liquid(fluid.particles.position),
        own_volume(bodies.boundary.volume),
        liquid_volume(fluid.volume) {}
  KOKKOS_INLINE_FUNCTION Real volume(Index s) const { return own_volume(sample(s)); }
  /// From the body's centre, m.
  KOKKOS_INLINE_FUNCTION Double3 arm(Index s) const { return minus(widen(position(s)), state(owner(s)).position); }
};

/// g_b of each sample of a dynamic body, and G/M and H ‖I⁻¹‖ of each body.
void find_body_rows(const Constants& constants, const Fluid& fluid, const NeighborLists& lists, Bodies& bodies) {
  const WetSamples samples(constants, fluid, lists, bodies);
  const Real rho = constants.rest_density;
  const Bodies& b = bodies;
  const Entries<const RigidBody> constant = b.constant;
  const Entries<Real> load = bodies.dynamic.row_load, arm_load = bodies.dynamic.row_arm,
                      bound = bodies.dynamic.row_bound;
  parallel(
      "drench::bodies::row_load", b.dynamic.count, KOKKOS_LAMBDA(const Index s) {
        const Real3 arm = narrow(samples.arm(s));
        Real push = 0, turn = 0;
        samples.list.for_each(s, [&](Index j) {
          const Real3 r = samples.liquid(j) - samples.position(s);
          const Real length = norm(r), factor = samples.kernel.grad_factor(length);
          push -= samples.liquid_volume(j) * factor * length;
          turn -= samples.liquid_volume(j) * factor * norm(cross(arm, r));
        });
        load(s) = rho * samples.volume(s) * push;
        arm_load(s) = rho * samples.volume(s) * turn;
      });
  fluid.exchange.share(bodies.dynamic.row_load, b.dynamic.count);
  fluid.exchange.share(bodies.dynamic.row_arm, b.dynamic.count);
  sum_over_samples(
      bodies, KOKKOS_LAMBDA(const Index s) {
        return Wrench{{double(load(s)), 0, 0}, {double(arm_load(s)), 0, 0}};
      });
  const Entries<const Wrench> sum = b.dynamic.load;
  parallel(
      "drench::bodies::row_bound", b.count, KOKKOS_LAMBDA(const Index k) {
        const RigidBody& body = constant(k);
        const Double3& i = body.inverse_inertia;
        bound(2 * k) = Real(body.inverse_mass * sum(k).force.x);
        bound(2 * k + 1) = Real(larger(i.x, larger(i.y, i.z)) * sum(k).torque.x);
      });
}

}  // namespace

void add_body_rows(const Constants& constants, const NeighborLists& lists, Bodies& bodies, Fluid& fluid) {
  if (bodies.dynamic.count == 0) return;
  find_body_rows(constants, fluid, lists, bodies);
  const Kernel kernel = constants.kernel;
  const Bodies& b = bodies;
  const Entries<const RigidBody> constant = b.constant;
  const Entries<const RigidState> state = b.state;
  const Entries<const Real3> xf = std::as_const(fluid).particles.position, xb = b.boundary.position;
  const Entries<const Real> vb = b.boundary.volume, bound = b.dynamic.row_bound;
  const Entries<const Index> of = b.boundary.body;
  const Entries<Real> alpha = fluid.alpha;
  const Real row_share = Real(constants.model.row_share());
  const Neighbors lb(lists.fluid_boundary);
  parallel(
      "drench::bodies::alpha", fluid.particles.count, KOKKOS_LAMBDA(const Index i) {
        const NeighborRow near = lb.row(i);
        if (near.count == 0 || alpha(i) == 0) return;
        Real coupling = 0;
        near.for_each([&](Index s) {
          const Index body = of(s);
          if (!constant(body).dynamic) return;
          const Real3 arm = narrow(minus(widen(xb(s)), state(body).position)), r = xf(i) - xb(s);
          const Real length = norm(r);
          coupling -= vb(s) * kernel.grad_factor(length) *
                      (length * bound(2 * body) + norm(cross(arm, r)) * bound(2 * body + 1));
        });
        if (coupling > 0) alpha(i) = 1 / (1 / alpha(i) + mirrored * mirrored * row_share * coupling);
      });
}

namespace {

template <class Friction>
void find_viscous_forces(const Constants& constants, const Fluid& fluid, const NeighborLists& lists, Bodies& bodies,
                         const Friction& friction) {
  const WetSamples samples(constants, fluid, lists, bodies);
  const Real strength = solid_friction * viscous_strength(constants) * constants.rest_density;
  const Entries<const Real3> us = std::as_const(bodies).boundary.velocity, v = fluid.particles.velocity;
  const Entries<const Real> ratio = fluid.particles.density_ratio;
  const Entries<Real3> force = bodies.dynamic.force;
  const Entries<Real> bound = bodies.dynamic.viscous_bound;
  parallel(
      "drench::bodies::viscous_force", bodies.dynamic.count, KOKKOS_LAMBDA(const Index s) {
        ViscousSum sum;
        if (strength > 0) {
          samples.list.for_each(s, [&](Index i) {
            const Real3 r = samples.position(s) - samples.liquid(i);
            friction.on_body(sum, samples.sample(s), samples.liquid_volume(i) / bounded_ratio(ratio(i)),
                             us(samples.sample(s)) - v(i), r, samples.kernel.gradient(r));
          });
        }
        force(s) = (strength * samples.volume(s)) * sum.pull;
        bound(s) = strength * samples.volume(s) * sum.bound;
      });
  fluid.exchange.share(bodies.dynamic.force, bodies.dynamic.count);
  fluid.exchange.share(bodies.dynamic.viscous_bound, bodies.dynamic.count);
}

}  // namespace

void viscous_body_forces(const Constants& constants, Fluid& fluid, const NeighborLists& lists, Bodies& bodies,
                         const Cloth& cloth, const WallSlip& slip) {
  if (bodies.dynamic.count == 0) return;
  fluid.exchange.halo(fluid.particles.velocity);
  fluid.exchange.halo(fluid.particles.density_ratio);
  with_slip(constants, slip, bodies, cloth,
            [&](const auto& friction) { find_viscous_forces(constants, fluid, lists, bodies, friction); });
}

void find_viscous_body_bound(Bodies& bodies, MaximaUnderWay& maxima) {
  if (bodies.dynamic.count == 0) return;
  const Bodies& b = bodies;
  const Entries<const RigidBody> constant = b.constant;
  const Entries<const RigidState> state = b.state;
  const Entries<const Index> owner = b.dynamic.owner;
  const Entries<const Real3> position = b.dynamic.position;
  const Entries<const Real> bound = b.dynamic.viscous_bound;
  sum_over_samples(
      bodies, KOKKOS_LAMBDA(const Index s) {
        const Double3 arm = minus(widen(position(s)), state(owner(s)).position);
        const double k = double(bound(s));
        return Wrench{{k, 0, 0}, {k * inner(arm, arm), 0, 0}};
      });
  const Entries<const Wrench> sum = b.dynamic.load;
  maxima.add(
      "drench::bodies::viscous_bound", b.count, KOKKOS_LAMBDA(const Index k) {
        const RigidBody& body = constant(k);
        const Double3& i = body.inverse_inertia;
        return 2 * larger(body.inverse_mass * sum(k).force.x, larger(i.x, larger(i.y, i.z)) * sum(k).torque.x);
      });
}

namespace {

/// dynamic.held: what dynamic.load, contacts and hinges change in bodies' velocities, m/s and rad/s.
void hold_predicted(Bodies& bodies, double dt) {
  const std::vector<RigidState> now = to_host<RigidState>(bodies.state, bodies.count);
  const std::vector<Wrench> load = to_host<Wrench>(bodies.dynamic.load, bodies.count);
  std::vector<RigidState> free = now;
  for (std::size_t b = 0; b < free.size(); ++b) {
    const RigidBody& body = bodies.constant_on_host[b];
    if (!body.dynamic) continue;
    free[b].velocity = add(now[b].velocity, times(dt * body.inverse_mass, load[b].force));
    free[b].spin = add(now[b].spin, times(dt, over_inertia(body, now[b].orientation, load[b].torque)));
  }
  std::vector<Wrench> change;
  const std::vector<RigidState> left = held(bodies, free);
  for (std::size_t b = 0; b < now.size(); ++b)
    change.push_back({minus(left[b].velocity, now[b].velocity), minus(left[b].spin, now[b].spin)});
  if (!bodies.dynamic.held.exists()) bodies.dynamic.held = to_device<Wrench>("drench::body_held", change);
  copy_to_device<Wrench>(bodies.dynamic.held, change);
}

}  // namespace

void predict_bodies(const Constants& constants, const Fluid& fluid, const NeighborLists& lists,
                    const Field<Real>& pressure, double dt, Bodies& bodies) {
  if (bodies.dynamic.count == 0) return;
  const WetSamples samples(constants, fluid, lists, bodies);
  const Real rho = constants.rest_density;
  const Bodies& b = bodies;
  const Entries<const RigidBody> constant = b.constant;
  const Entries<const Real3> v = b.boundary.velocity;
  const Entries<const Real> kappa = pressure;
  const Entries<Real3> force = bodies.dynamic.force, predicted = bodies.dynamic.predicted;
  parallel(
      "drench::bodies::pressure_force", b.dynamic.count, KOKKOS_LAMBDA(const Index s) {
        Real3 f;
        samples.list.for_each(s, [&](Index i) {
          if (kappa(i) == 0) return;
          const Real3 r = samples.liquid(i) - samples.position(s);
          f += samples.liquid_volume(i) * kappa(i) * samples.kernel.grad_factor(norm(r)) * r;
        });
        force(s) = mirrored * rho * samples.volume(s) * f;
      });
  fluid.exchange.share(bodies.dynamic.force, b.dynamic.count);
  sum_sample_forces(bodies);
  const Entries<const Wrench> load = b.dynamic.load;
  const bool holds = b.holding.any;
  if (holds) hold_predicted(bodies, dt);
  const Entries<const Wrench> left = b.dynamic.held;
  parallel(
      "drench::bodies::predicted", b.dynamic.count, KOKKOS_LAMBDA(const Index s) {
        const Index k = samples.owner(s), at = samples.sample(s);
        const RigidState& now = samples.state(k);
        Double3 gain = times(dt * constant(k).inverse_mass, load(k).force);
        Double3 turn = times(dt, over_inertia(constant(k), now.orientation, load(k).torque));
        if (holds) {
          gain = left(k).force;
          turn = left(k).torque;
        }
        predicted(at) = v(at) + narrow(add(gain, outer(turn, samples.arm(s))));
      });
}

}  // namespace drench::kokkos_backend
