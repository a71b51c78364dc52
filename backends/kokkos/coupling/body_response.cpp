#include "coupling/body_response.hpp"

#include "bodies/sample_sums.hpp"
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
      "drench::bodies::sample_position", dynamic.count,
      KOKKOS_LAMBDA(const Index s) { position(s) = x(sample(s)); });
  build_neighbor_list({&lists.boundary_fluid, &dynamic.position, dynamic.count, fluid.cells.view()},
                      constants.support);
}

MemoryEstimate body_neighbor_bytes(const Sizing& s) {
  MemoryEstimate sum;
  if (s.size.fluid > 0 && s.size.dynamic_samples > 0)
    sum.lists = list_bytes(s.size.dynamic_samples, s.entries.boundary_fluid, s);
  return sum;
}

namespace {

/// g_b of each sample of a dynamic body, and G/M and H ‖I⁻¹‖ of each body.
void find_body_rows(const Constants& constants, const Fluid& fluid, const NeighborLists& lists, Bodies& bodies) {
  const Kernel kernel = constants.kernel;
  const Real rho = constants.rest_density;
  const Bodies& b = bodies;
  const Entries<const RigidBody> constant = b.constant;
  const Entries<const RigidState> state = b.state;
  const Entries<const Index> sample = b.dynamic.sample, owner = b.dynamic.owner;
  const Entries<const Real3> xs = b.dynamic.position, xf = fluid.particles.position;
  const Entries<const Real> vb = b.boundary.volume, vf = fluid.volume;
  const Entries<Real> load = bodies.dynamic.row_load, arm_load = bodies.dynamic.row_arm,
                      bound = bodies.dynamic.row_bound;
  const Neighbors list(lists.boundary_fluid);
  parallel(
      "drench::bodies::row_load", b.dynamic.count, KOKKOS_LAMBDA(const Index s) {
        const Real3 arm = narrow(minus(widen(xs(s)), state(owner(s)).position));
        Real push = 0, turn = 0;
        const NeighborRow near = list.row(s);
        for (Index k = 0; k < near.count; ++k) {
          const Real3 r = xf(near(k)) - xs(s);
          const Real length = norm(r), factor = kernel.grad_factor(length);
          push -= vf(near(k)) * factor * length;
          turn -= vf(near(k)) * factor * norm(cross(arm, r));
        }
        load(s) = rho * vb(sample(s)) * push;
        arm_load(s) = rho * vb(sample(s)) * turn;
      });
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
        bound(2 * k + 1) = Real(Kokkos::fmax(i.x, Kokkos::fmax(i.y, i.z)) * sum(k).torque.x);
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
  const Neighbors lb(lists.fluid_boundary);
  parallel(
      "drench::bodies::alpha", fluid.particles.count, KOKKOS_LAMBDA(const Index i) {
        const NeighborRow near = lb.row(i);
        if (near.count == 0 || alpha(i) == 0) return;
        Real coupling = 0;
        for (Index k = 0; k < near.count; ++k) {
          const Index s = near(k), body = of(s);
          if (!constant(body).dynamic) continue;
          const Real3 arm = narrow(minus(widen(xb(s)), state(body).position)), r = xf(i) - xb(s);
          const Real length = norm(r);
          coupling -= vb(s) * kernel.grad_factor(length) *
                      (length * bound(2 * body) + norm(cross(arm, r)) * bound(2 * body + 1));
        }
        if (coupling > 0) alpha(i) = 1 / (1 / alpha(i) + mirrored * mirrored * body_row_share * coupling);
      });
}

void viscous_body_forces(const Constants& constants, const Fluid& fluid, const NeighborLists& lists,
                         Bodies& bodies) {
  if (bodies.dynamic.count == 0) return;
  const Kernel kernel = constants.kernel;
  const Real strength = solid_friction * viscous_strength(constants) * constants.rest_density;
  const Bodies& b = bodies;
  const Entries<const Index> sample = b.dynamic.sample;
  const Entries<const Real3> xs = b.dynamic.position, xf = fluid.particles.position, us = b.boundary.velocity,
                             v = fluid.particles.velocity;
  const Entries<const Real> vb = b.boundary.volume, volume = fluid.volume, ratio = fluid.particles.density_ratio;
  const Entries<Real3> force = bodies.dynamic.force;
  const Entries<Real> bound = bodies.dynamic.viscous_bound;
  const Neighbors list(lists.boundary_fluid);
  parallel(
      "drench::bodies::viscous_force", b.dynamic.count, KOKKOS_LAMBDA(const Index s) {
        ViscousSum sum;
        if (strength > 0) {
          const NeighborRow near = list.row(s);
          for (Index k = 0; k < near.count; ++k) {
            const Index i = near(k);
            const Real3 r = xs(s) - xf(i);
            sum.add(volume(i) / bounded_ratio(ratio(i)), us(sample(s)) - v(i), r, kernel.gradient(r));
          }
        }
        force(s) = (strength * vb(sample(s))) * sum.pull;
        bound(s) = strength * vb(sample(s)) * sum.bound;
      });
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
        return 2 * Kokkos::fmax(body.inverse_mass * sum(k).force.x,
                                Kokkos::fmax(i.x, Kokkos::fmax(i.y, i.z)) * sum(k).torque.x);
      });
}

void predict_bodies(const Constants& constants, const Fluid& fluid, const NeighborLists& lists,
                    const Field<Real>& pressure, double dt, Bodies& bodies) {
  if (bodies.dynamic.count == 0) return;
  const Kernel kernel = constants.kernel;
  const Real rho = constants.rest_density;
  const Bodies& b = bodies;
  const Entries<const RigidBody> constant = b.constant;
  const Entries<const RigidState> state = b.state;
  const Entries<const Index> sample = b.dynamic.sample, owner = b.dynamic.owner;
  const Entries<const Real3> xs = b.dynamic.position, xf = fluid.particles.position, v = b.boundary.velocity;
  const Entries<const Real> vb = b.boundary.volume, vf = fluid.volume, kappa = pressure;
  const Entries<Real3> force = bodies.dynamic.force, predicted = bodies.dynamic.predicted;
  const Neighbors list(lists.boundary_fluid);
  parallel(
      "drench::bodies::pressure_force", b.dynamic.count, KOKKOS_LAMBDA(const Index s) {
        Real3 f;
        const NeighborRow near = list.row(s);
        for (Index k = 0; k < near.count; ++k) {
          const Index i = near(k);
          if (kappa(i) == 0) continue;
          const Real3 r = xf(i) - xs(s);
          f += vf(i) * kappa(i) * kernel.grad_factor(norm(r)) * r;
        }
        force(s) = mirrored * rho * vb(sample(s)) * f;
      });
  sum_sample_forces(bodies);
  const Entries<const Wrench> load = b.dynamic.load;
  parallel(
      "drench::bodies::predicted", b.dynamic.count, KOKKOS_LAMBDA(const Index s) {
        const Index k = owner(s);
        const Double3 a = times(constant(k).inverse_mass, load(k).force);
        const Double3 turn = over_inertia(constant(k), state(k).orientation, load(k).torque);
        const Double3 arm = minus(widen(xs(s)), state(k).position);
        predicted(sample(s)) = v(sample(s)) + narrow(times(dt, add(a, outer(turn, arm))));
      });
}

}  // namespace drench::kokkos_backend
