#include "rigid_bodies.hpp"

#include <stdexcept>

#include "device_copy.hpp"
#include "laws/contact.hpp"
#include "laws/viscosity.hpp"
#include "laws/wall.hpp"
#include "primitives/neighbor_list.hpp"

namespace drench::kokkos_backend {
namespace {

constexpr Index parts = 64;            // of a body's sum
constexpr Real row_share = Real(0.3);  // of the absolute row sum, as for the cloth (stage density)

Double3 to_double(const Vec3& a) { return {a[0], a[1], a[2]}; }
Vec3 to_vec(const Double3& a) { return {a.x, a.y, a.z}; }
Double3 inverse(const Vec3& a) { return a[0] > 0 ? Double3{1 / a[0], 1 / a[1], 1 / a[2]} : Double3{}; }

RigidBody constant_of(const Body& b) {
  RigidBody c{};
  c.kind = static_cast<int>(b.kind);
  c.moves = b.moves() ? 1 : 0;
  c.dynamic = b.dynamic ? 1 : 0;
  c.slides = b.slides ? 1 : 0;
  c.lattice[0] = to_double(b.lattice[0]);
  c.lattice[1] = to_double(b.lattice[1]);
  c.middle = to_double(b.middle);
  c.rest_center = to_double(b.center);
  c.rest_velocity = to_double(b.velocity);
  c.rest_spin = times(b.spin_rate, to_double(b.spin_axis));
  c.inverse_mass = b.dynamic ? 1 / b.mass : 0;
  c.inertia = to_double(b.inertia);
  c.inverse_inertia = inverse(b.inertia);
  c.half = times(0.5, minus(to_double(b.box.max), to_double(b.box.min)));
  c.radius = b.radius;
  c.reach = b.reach;
  c.first_sample = b.first_sample;
  c.sample_count = b.sample_count;
  return c;
}

void make_bodies(Device& d) {
  BodyArrays& a = d.bodies;
  std::vector<RigidBody> constants;
  std::vector<Index> sample, owner;
  for (std::size_t b = 0; b < d.model.bodies.size(); ++b) {
    const Body& body = d.model.bodies[b];
    constants.push_back(constant_of(body));
    if (!body.dynamic) continue;
    constants.back().first_dynamic = static_cast<Index>(sample.size());
    for (Index s = 0; s < body.sample_count; ++s) {
      sample.push_back(body.first_sample + s);
      owner.push_back(static_cast<Index>(b));
    }
  }
  a.constant = to_device<RigidBody>("drench::body_constant", constants);
  a.samples = static_cast<Index>(sample.size());
  if (a.samples == 0) return;
  a.sample = to_device<Index>("drench::body_sample", sample);
  a.owner = to_device<Index>("drench::body_owner", owner);
  a.position = Array<Real3>("drench::body_sample_position", sample.size());
  a.force = Array<Real3>("drench::body_force", sample.size());
  a.row_load = Array<Real>("drench::body_row_load", sample.size());
  a.row_arm = Array<Real>("drench::body_row_arm", sample.size());
  a.row_bound = Array<Real>("drench::body_row_bound", 2 * constants.size());
  a.part = Array<Wrench>("drench::body_part", parts * constants.size());
  a.load = Array<Wrench>("drench::body_load", constants.size());
  a.change = Array<Wrench>("drench::body_change", constants.size());
}

/// bodies.load = Σ term(s) over each dynamic body's samples, in a fixed order.
template <class Term>
void sum_over_samples(Device& d, const Term& term) {
  const auto constant = d.bodies.constant;
  const auto part = d.bodies.part, load = d.bodies.load;
  parallel(
      "drench::bodies::part", parts * d.bodies.count, KOKKOS_LAMBDA(const Index k) {
        const RigidBody& body = constant(k / parts);
        Wrench sum;
        if (body.dynamic)
          for (Index s = k % parts; s < body.sample_count; s += parts) sum += term(body.first_dynamic + s);
        part(k) = sum;
      });
  parallel(
      "drench::bodies::load", d.bodies.count, KOKKOS_LAMBDA(const Index b) {
        Wrench sum;
        for (Index p = 0; p < parts; ++p) sum += part(b * parts + p);
        load(b) = sum;
      });
}

/// Forces on the samples → forces and torques of the bodies.
void sum_forces(Device& d) {
  const auto state = d.bodies.state;
  const auto owner = d.bodies.owner;
  const auto position = d.bodies.position, force = d.bodies.force;
  sum_over_samples(
      d, KOKKOS_LAMBDA(const Index s) {
        const Double3 f = widen(force(s));
        return Wrench{f, outer(minus(widen(position(s)), state(owner(s)).position), f)};
      });
}

}  // namespace

void upload_bodies(Device& d, const HostState& s) {
  BodyArrays& a = d.bodies;
  const std::size_t count = d.model.bodies.size();
  if (s.body_position.size() != count || s.body_orientation.size() != count || s.body_velocity.size() != count ||
      s.body_angular_velocity.size() != count)
    throw std::runtime_error("upload: the state's bodies are not the model's");
  a.count = static_cast<Index>(count);
  if (!d.model.has_moving_body()) {
    a.still_position = s.body_position;
    a.still_velocity = s.body_velocity;
    a.still_spin = s.body_angular_velocity;
    a.still_orientation = s.body_orientation;
    return;
  }
  if (a.constant.extent(0) == 0) make_bodies(d);
  std::vector<RigidState> states;
  for (std::size_t b = 0; b < count; ++b) {
    const Quaternion& q = s.body_orientation[b];
    states.push_back({to_double(s.body_position[b]),
                      to_double(s.body_velocity[b]),
                      to_double(s.body_angular_velocity[b]),
                      {q[0], q[1], q[2], q[3]}});
  }
  a.state = to_device<RigidState>("drench::body_state", states);
  if (a.samples > 0) a.predicted = to_device3("drench::body_predicted", s.boundary_velocity);
}

void download_bodies(const Device& d, HostState& s) {
  const BodyArrays& a = d.bodies;
  s.body_position = a.still_position;
  s.body_velocity = a.still_velocity;
  s.body_angular_velocity = a.still_spin;
  s.body_orientation = a.still_orientation;
  if (!d.model.has_moving_body()) return;
  for (const RigidState& b : to_host<RigidState>(a.state, a.count)) {
    s.body_position.push_back(to_vec(b.position));
    s.body_velocity.push_back(to_vec(b.velocity));
    s.body_angular_velocity.push_back(to_vec(b.spin));
    s.body_orientation.push_back({b.orientation.w, b.orientation.x, b.orientation.y, b.orientation.z});
  }
}

void place_solids(Device& d, double dt) {
  if (!d.model.has_moving_body()) return;
  const auto constant = d.bodies.constant;
  const auto state = d.bodies.state;
  const auto solids = d.solids;
  parallel(
      "drench::bodies::solids", d.bodies.count, KOKKOS_LAMBDA(const Index b) {
        const RigidBody& body = constant(b);
        if (!body.moves) return;
        const RigidState end = moved(state(b), dt);
        Solid s = solids(b);
        s.center = narrow(end.position);
        s.point = s.center;
        s.half = narrow(body.half);
        s.velocity = narrow(end.velocity);
        s.spin = narrow(end.spin);
        s.axis[0] = narrow(turned(end.orientation, {1, 0, 0}));
        s.axis[1] = narrow(turned(end.orientation, {0, 1, 0}));
        s.axis[2] = narrow(turned(end.orientation, {0, 0, 1}));
        s.normal = to_world(s, s.rest_normal);
        solids(b) = s;
      });
}

double fastest_body(Device& d, double fall) {
  const auto constant = d.bodies.constant;
  const auto state = d.bodies.state;
  return maximum(
      "drench::time_step::body_speed", d.bodies.count, KOKKOS_LAMBDA(const Index b) {
        if (!constant(b).moves) return 0.0;
        const RigidState& s = state(b);
        return Kokkos::sqrt(inner(s.velocity, s.velocity)) + Kokkos::sqrt(inner(s.spin, s.spin)) * constant(b).reach +
               (constant(b).dynamic ? fall : 0.0);
      });
}

void list_body_neighbors(Device& d) {
  if (d.bodies.samples == 0) return;
  const auto sample = d.bodies.sample;
  const auto position = d.bodies.position, x = d.boundary.position;
  parallel(
      "drench::bodies::sample_position", d.bodies.samples,
      KOKKOS_LAMBDA(const Index s) { position(s) = x(sample(s)); });
  build_neighbor_list({&d.boundary_fluid, position, d.bodies.samples, d.fluid_cells.view()}, d.support);
}

void refresh_body_samples(Device& d) {
  const auto sample = d.bodies.sample, owner = d.bodies.owner;
  const auto state = d.bodies.state;
  const auto position = d.bodies.position, v = d.boundary.velocity;
  parallel(
      "drench::bodies::sample_velocity", d.bodies.samples, KOKKOS_LAMBDA(const Index s) {
        const RigidState& body = state(owner(s));
        v(sample(s)) = narrow(add(body.velocity, outer(body.spin, minus(widen(position(s)), body.position))));
      });
}

void add_body_rows(Device& d) {
  if (d.bodies.samples == 0) return;
  const Kernel kernel = d.kernel;
  const Real rho = d.rest_density;
  const auto constant = d.bodies.constant;
  const auto state = d.bodies.state;
  const auto sample = d.bodies.sample, owner = d.bodies.owner;
  const auto xs = d.bodies.position, xf = d.fluid.position, xb = d.boundary.position;
  const auto vb = d.boundary.volume, vf = d.work.volume, alpha = d.work.alpha;
  const auto load = d.bodies.row_load, arm_load = d.bodies.row_arm, bound = d.bodies.row_bound;
  const Neighbors list(d.boundary_fluid), lb(d.fluid_boundary);
  parallel(
      "drench::bodies::row_load", d.bodies.samples, KOKKOS_LAMBDA(const Index s) {
        const Real3 arm = narrow(minus(widen(xs(s)), state(owner(s)).position));
        Real push = 0, turn = 0;
        const NeighborRow near = list.row(s);
        for (Index k = 0; k < near.count; ++k) {
          const Real3 r = xf(near(k)) - xs(s);
          const Real length = norm(r), slope = kernel.slope(length);
          push -= vf(near(k)) * slope * length;
          turn -= vf(near(k)) * slope * norm(cross(arm, r));
        }
        load(s) = rho * vb(sample(s)) * push;
        arm_load(s) = rho * vb(sample(s)) * turn;
      });
  sum_over_samples(
      d, KOKKOS_LAMBDA(const Index s) {
        return Wrench{{double(load(s)), 0, 0}, {double(arm_load(s)), 0, 0}};
      });
  const auto sum = d.bodies.load;
  parallel(
      "drench::bodies::row_bound", d.bodies.count, KOKKOS_LAMBDA(const Index b) {
        const RigidBody& body = constant(b);
        const Double3& i = body.inverse_inertia;
        bound(2 * b) = Real(body.inverse_mass * sum(b).force.x);
        bound(2 * b + 1) = Real(Kokkos::fmax(i.x, Kokkos::fmax(i.y, i.z)) * sum(b).torque.x);
      });
  const auto of = d.boundary.body;
  parallel(
      "drench::bodies::alpha", d.fluid.count, KOKKOS_LAMBDA(const Index i) {
        const NeighborRow near = lb.row(i);
        if (near.count == 0 || alpha(i) == 0) return;
        Real coupling = 0;
        for (Index k = 0; k < near.count; ++k) {
          const Index b = near(k), body = of(b);
          if (!constant(body).dynamic) continue;
          const Real3 arm = narrow(minus(widen(xb(b)), state(body).position)), r = xf(i) - xb(b);
          const Real length = norm(r);
          coupling -=
              vb(b) * kernel.slope(length) * (length * bound(2 * body) + norm(cross(arm, r)) * bound(2 * body + 1));
        }
        if (coupling > 0) alpha(i) = 1 / (1 / alpha(i) + mirrored * mirrored * row_share * coupling);
      });
}

void viscous_body_forces(Device& d) {
  if (d.bodies.samples == 0) return;
  const Kernel kernel = d.kernel;
  const Real strength = solid_friction * d.viscous_strength * d.rest_density;
  const auto sample = d.bodies.sample;
  const auto xs = d.bodies.position, xf = d.fluid.position, us = d.boundary.velocity, v = d.fluid.velocity,
             force = d.bodies.force;
  const auto vb = d.boundary.volume, volume = d.work.volume, ratio = d.fluid.density_ratio;
  const auto bound = d.bodies.row_load;
  const Neighbors list(d.boundary_fluid);
  parallel(
      "drench::bodies::viscous_force", d.bodies.samples, KOKKOS_LAMBDA(const Index s) {
        ViscousSum sum;
        if (strength > 0) {
          const NeighborRow near = list.row(s);
          for (Index k = 0; k < near.count; ++k) {
            const Index i = near(k);
            const Real3 r = xs(s) - xf(i);
            const Real delta = ratio(i) < Real(0.5) ? Real(0.5) : ratio(i);
            sum.add(volume(i) / delta, us(sample(s)) - v(i), r, kernel.gradient(r));
          }
        }
        force(s) = (strength * vb(sample(s))) * sum.pull;
        bound(s) = strength * vb(sample(s)) * sum.bound;
      });
}

void find_viscous_body_bound(Device& d, MaximaUnderWay& maxima) {
  if (d.bodies.samples == 0) return;
  const auto constant = d.bodies.constant;
  const auto state = d.bodies.state;
  const auto owner = d.bodies.owner;
  const auto position = d.bodies.position;
  const auto bound = d.bodies.row_load;
  sum_over_samples(
      d, KOKKOS_LAMBDA(const Index s) {
        const Double3 arm = minus(widen(position(s)), state(owner(s)).position);
        const double k = double(bound(s));
        return Wrench{{k, 0, 0}, {k * inner(arm, arm), 0, 0}};
      });
  const auto sum = d.bodies.load;
  maxima.add(
      "drench::bodies::viscous_bound", d.bodies.count, KOKKOS_LAMBDA(const Index b) {
        const RigidBody& body = constant(b);
        const Double3& i = body.inverse_inertia;
        return 2 * Kokkos::fmax(body.inverse_mass * sum(b).force.x,
                                Kokkos::fmax(i.x, Kokkos::fmax(i.y, i.z)) * sum(b).torque.x);
      });
}

void body_stage(Device& d, double keep, double weight, bool gravity) {
  if (d.bodies.samples == 0) return;
  sum_forces(d);
  const auto constant = d.bodies.constant;
  const auto state = d.bodies.state;
  const auto load = d.bodies.load, change = d.bodies.change;
  const Double3 g = gravity ? widen(d.gravity) : Double3{};
  parallel(
      "drench::bodies::velocity", d.bodies.count, KOKKOS_LAMBDA(const Index b) {
        const RigidBody& body = constant(b);
        if (!body.dynamic) return;
        Wrench next;
        next.force = times(weight, add(load(b).force, times(1 / body.inverse_mass, g)));
        next.torque = times(weight, load(b).torque);
        if (keep > 0) next += Wrench{times(keep, change(b).force), times(keep, change(b).torque)};
        change(b) = next;
        RigidState s = state(b);
        s.velocity = add(s.velocity, times(body.inverse_mass, next.force));
        s.spin = add(s.spin, over_inertia(body, s.orientation, next.torque));
        state(b) = s;
      });
  refresh_body_samples(d);
}

void body_response(Device& d, const Array<Real>& kappa, double dt) {
  if (d.bodies.samples == 0) return;
  const Kernel kernel = d.kernel;
  const Real rho = d.rest_density;
  const auto constant = d.bodies.constant;
  const auto state = d.bodies.state;
  const auto sample = d.bodies.sample, owner = d.bodies.owner;
  const auto xs = d.bodies.position, xf = d.fluid.position, force = d.bodies.force;
  const auto vb = d.boundary.volume, vf = d.work.volume;
  const Neighbors list(d.boundary_fluid);
  parallel(
      "drench::bodies::pressure_force", d.bodies.samples, KOKKOS_LAMBDA(const Index s) {
        Real3 f;
        const NeighborRow near = list.row(s);
        for (Index k = 0; k < near.count; ++k) {
          const Index i = near(k);
          if (kappa(i) == 0) continue;
          const Real3 r = xf(i) - xs(s);
          f += vf(i) * kappa(i) * kernel.slope(norm(r)) * r;
        }
        force(s) = mirrored * rho * vb(sample(s)) * f;
      });
  sum_forces(d);
  const auto load = d.bodies.load;
  const auto v = d.boundary.velocity, predicted = d.bodies.predicted;
  parallel(
      "drench::bodies::predicted", d.bodies.samples, KOKKOS_LAMBDA(const Index s) {
        const Index b = owner(s);
        const Double3 a = times(constant(b).inverse_mass, load(b).force);
        const Double3 turn = over_inertia(constant(b), state(b).orientation, load(b).torque);
        const Double3 arm = minus(widen(xs(s)), state(b).position);
        predicted(sample(s)) = v(sample(s)) + narrow(times(dt, add(a, outer(turn, arm))));
      });
}

void accept_bodies(Device& d, double dt) { body_stage(d, 0, dt, false); }

}  // namespace drench::kokkos_backend
