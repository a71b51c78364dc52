#include "coupling/wall_push.hpp"

#include "bodies/sample_sums.hpp"
#include "coupling/wall.hpp"

namespace drench::kokkos_backend {

double wall_push_bytes(const Sizing& s) {
  const bool extrapolates = s.size.scene.fluid.wall_pressure == WallPressure::extrapolated;
  return s.size.dynamic_samples > 0 && extrapolates ? 3 * s.real : 0;
}

Entries<Real3> room_for_wall_push(Fluid& fluid) {
  make_room(fluid.wall_gain.push, "drench::fluid_wall_push", fluid.particles.capacity());
  return fluid.wall_gain.push;
}

namespace {

/// fluid.wall_gain.push: of a change of velocity what the walls gave, over the sum of their samples' shares.
void find_gifts(const NeighborLists& lists, const Bodies& bodies, Fluid& fluid) {
  const Entries<const Real3> x = std::as_const(fluid).particles.position, xb = bodies.boundary.position,
                             diagonal = std::as_const(fluid).wall_gain.diagonal,
                             shear = std::as_const(fluid).wall_gain.shear;
  const Entries<Real3> push = fluid.wall_gain.push;
  const Neighbors walls(lists.fluid_boundary);
  parallel(
      "drench::bodies::wall_push", fluid.particles.count, KOKKOS_LAMBDA(const Index i) {
        Real shares = 0;
        walls.for_each(i, [&](Index j, Real factor) {
          const Real3 r = x(i) - xb(j);
          shares -= factor * dot(r, r);
        });
        const Real3 change = push(i);
        push(i) = shares > 0 ? (1 / shares) * (change - over_gain(diagonal(i), shear(i), change)) : Real3{};
      });
  fluid.exchange.halo(fluid.wall_gain.push);
}

/// dynamic.force and couple: the opposite of it on each sample, kg m/s and kg m²/s about the sample.
void find_impulses(const Constants& constants, const NeighborLists& lists, const Fluid& fluid, Bodies& bodies) {
  DynamicSamples& dynamic = bodies.dynamic;
  make_room(dynamic.couple, "drench::body_couple", static_cast<std::size_t>(dynamic.count));
  const Kernel kernel = constants.kernel;
  const Real rho = constants.rest_density;
  const Entries<const Index> sample = std::as_const(dynamic).sample;
  const Entries<const Real3> x = fluid.particles.position, xb = std::as_const(dynamic).position,
                             push = fluid.wall_gain.push;
  const Entries<const Real> volume = fluid.volume, own_volume = std::as_const(bodies).boundary.volume;
  const Entries<Real3> force = dynamic.force, couple = dynamic.couple;
  const Neighbors list(lists.boundary_fluid);
  parallel(
      "drench::bodies::wall_reaction", dynamic.count, KOKKOS_LAMBDA(const Index s) {
        Real3 sum, turn;
        list.for_each(s, [&](Index i) {
          const Real3 r = x(i) - xb(s);
          const Real3 f = (volume(i) * kernel.grad_factor(norm(r)) * dot(r, r)) * push(i);  // the factor is negative
          sum += f;
          turn += cross(r, f);
        });
        const Real mass = rho * own_volume(sample(s));
        force(s) = mass * sum;
        couple(s) = mass * turn;
      });
  fluid.exchange.share(dynamic.force, dynamic.count);
  fluid.exchange.share(dynamic.couple, dynamic.count);
}

/// dynamic.load: the impulses on the bodies.
void find_loads(const Constants& constants, const NeighborLists& lists, Fluid& fluid, Bodies& bodies) {
  find_gifts(lists, bodies, fluid);
  find_impulses(constants, lists, fluid, bodies);
  const DynamicSamples& dynamic = bodies.dynamic;
  const Entries<const RigidState> state = std::as_const(bodies).state;
  const Entries<const Index> owner = dynamic.owner;
  const Entries<const Real3> xb = dynamic.position, impulse = dynamic.force, couple = dynamic.couple;
  sum_over_samples(
      bodies, KOKKOS_LAMBDA(const Index s) {
        const Double3 f = widen(impulse(s)), arm = minus(widen(xb(s)), state(owner(s)).position);
        return Wrench{f, add(outer(arm, f), widen(couple(s)))};
      });
}

}  // namespace

void push_bodies_back(const Constants& constants, const NeighborLists& lists, Fluid& fluid, Bodies& bodies) {
  find_loads(constants, lists, fluid, bodies);
  move_by_load(bodies, 0, 1, nullptr);
}

void push_bodies_ahead(const Constants& constants, const NeighborLists& lists, Fluid& fluid, Bodies& bodies,
                       Field<Wrench>& kept) {
  find_loads(constants, lists, fluid, bodies);
  make_room(kept, "drench::body_ahead", static_cast<std::size_t>(bodies.count));
  const Entries<const Wrench> load = std::as_const(bodies).dynamic.load;
  const Entries<Wrench> ahead = kept;
  parallel(
      "drench::bodies::wall_push_kept", bodies.count, KOKKOS_LAMBDA(const Index b) { ahead(b) = load(b); });
  move_by_load(bodies, 0, 1, nullptr);
}

void push_bodies_further(const Constants& constants, const NeighborLists& lists, Fluid& fluid, Bodies& bodies,
                         const Field<Wrench>& kept) {
  find_loads(constants, lists, fluid, bodies);
  const Entries<Wrench> load = bodies.dynamic.load;
  const Entries<const Wrench> ahead = kept;
  parallel(
      "drench::bodies::wall_push_rest", bodies.count, KOKKOS_LAMBDA(const Index b) {
        load(b) = {minus(load(b).force, ahead(b).force), minus(load(b).torque, ahead(b).torque)};
      });
  move_by_load(bodies, 0, 1, nullptr);
}

}  // namespace drench::kokkos_backend
