// The solid bodies' arrays, where their surfaces are, and how dynamic ones take up momentum.

#include <Eigen/Geometry>
#include <algorithm>
#include <stdexcept>

#include "base/eigen_vec.hpp"
#include "bodies/bodies.hpp"
#include "bodies/contact.hpp"
#include "bodies/deforming_body.hpp"
#include "bodies/sample_sums.hpp"
#include "core/host_copy.hpp"
#include "core/reduce.hpp"

namespace drench::kokkos_backend {
namespace {

std::vector<RigidMotion> motions_of(const std::vector<RigidState>& states) {
  std::vector<RigidMotion> motions;
  for (const RigidState& s : states) motions.push_back(motion_of(s));
  return motions;
}

Double3 inverse(const Vec3& a) { return a[0] > 0 ? Double3{1 / a[0], 1 / a[1], 1 / a[2]} : Double3{}; }

Solid solid_of(const Body& b, std::size_t index, const DistanceField& field) {
  Solid s{};
  s.body = static_cast<Index>(index);
  s.kind = static_cast<int>(b.kind);
  s.inside = b.inside ? 1 : 0;
  s.min = to_real(b.box.min);
  s.max = to_real(b.box.max);
  s.center = to_real(b.center);
  s.point = to_real(b.point);
  s.normal = to_real(b.normal);
  s.radius = Real(b.radius);
  s.moves = b.moves() ? 1 : 0;
  s.rest_normal = s.normal;
  for (std::size_t a = 0; a < 3; ++a) s.field_points[a] = field.points[a];
  s.field_spacing = Real(field.spacing);
  s.field_origin =
      to_real({field.origin[0] - b.center[0], field.origin[1] - b.center[1], field.origin[2] - b.center[2]});
  return s;
}

void make_solids(const Model& m, Bodies& bodies) {
  std::vector<double> values;
  std::vector<Solid> list;
  std::vector<std::size_t> first;  // where a solid's values begin
  const auto add = [&](std::size_t b, const DistanceField& field) {
    list.push_back(solid_of(m.bodies[b], b, field));
    first.push_back(values.size());
    if (!m.bodies[b].deforms()) values.insert(values.end(), field.value.begin(), field.value.end());
  };
  for (std::size_t b = 0; b < m.bodies.size(); ++b)
    add(b, m.bodies[b].has_parts() ? m.bodies[b].parts[0] : m.bodies[b].field);
  for (std::size_t b = 0; b < m.bodies.size(); ++b)
    if (m.bodies[b].has_parts()) add(b, m.bodies[b].parts[1]);
  if (!values.empty()) bodies.distance_fields = to_device<Real>("drench::distance_fields", values);
  first.push_back(values.size());
  for (std::size_t s = 0; s < list.size(); ++s)
    if (first[s] < first[s + 1]) list[s].field = bodies.distance_fields.data() + first[s];
  bodies.solids = to_device<Solid>("drench::solids", list);
}

RigidBody constant_of(const Body& b) {
  RigidBody c{};
  c.kind = static_cast<int>(b.kind);
  c.moves = b.moves() ? 1 : 0;
  c.dynamic = b.dynamic ? 1 : 0;
  c.slides = b.slides ? 1 : 0;
  c.measured = b.is_measured() ? 1 : 0;
  c.lattice[0] = to_double(b.lattice[0]);
  c.lattice[1] = to_double(b.lattice[1]);
  c.middle = to_double(b.middle);
  c.rest_center = to_double(b.center);
  c.keyed = b.has_keys() ? 1 : 0;
  c.rest_velocity = to_double(b.velocity.plain());
  c.rest_spin = times(b.spin_rate.plain(), to_double(b.spin_axis));
  c.inverse_mass = b.dynamic ? 1 / b.mass : 0;
  c.inertia = to_double(b.inertia);
  c.inverse_inertia = inverse(b.inertia);
  c.principal = {b.principal[0], b.principal[1], b.principal[2], b.principal[3]};
  c.half = times(0.5, minus(to_double(b.box.max), to_double(b.box.min)));
  c.radius = b.radius;
  c.reach = b.reach;
  c.first_sample = b.first_sample;
  c.sample_count = b.sample_count;
  return c;
}

void make_dynamic_samples(DynamicSamples& dynamic, const std::vector<Index>& sample, const std::vector<Index>& owner,
                          std::size_t bodies) {
  dynamic.count = static_cast<Index>(sample.size());
  if (dynamic.count == 0) return;
  dynamic.sample = to_device<Index>("drench::body_sample", sample);
  dynamic.owner = to_device<Index>("drench::body_owner", owner);
  allocate_zeros(dynamic.position, "drench::body_sample_position", sample.size());
  allocate_zeros(dynamic.force, "drench::body_force", sample.size());
  allocate_zeros(dynamic.row_load, "drench::body_row_load", sample.size());
  allocate_zeros(dynamic.row_arm, "drench::body_row_arm", sample.size());
  allocate_zeros(dynamic.row_bound, "drench::body_row_bound", 2 * bodies);
  allocate_zeros(dynamic.viscous_bound, "drench::body_viscous_bound", sample.size());
  allocate_zeros(dynamic.part, "drench::body_part", parts_per_body * bodies);
  allocate_zeros(dynamic.load, "drench::body_load", bodies);
  allocate_zeros(dynamic.change, "drench::body_change", bodies);
  allocate_zeros(dynamic.inner_change, "drench::body_inner_change", bodies);
  allocate_zeros(dynamic.given, "drench::body_given", bodies);
}

void make_bodies(const Model& m, Bodies& bodies) {
  std::vector<RigidBody> constants;
  std::vector<Index> sample, owner;
  for (std::size_t b = 0; b < m.bodies.size(); ++b) {
    const Body& body = m.bodies[b];
    constants.push_back(constant_of(body));
    if (!body.is_measured()) continue;
    constants.back().first_dynamic = static_cast<Index>(sample.size());
    for (Index s = 0; s < body.sample_count; ++s) {
      sample.push_back(body.first_sample + s);
      owner.push_back(static_cast<Index>(b));
    }
  }
  bodies.constant = to_device<RigidBody>("drench::body_constant", constants);
  bodies.constant_on_host = constants;
  make_dynamic_samples(bodies.dynamic, sample, owner, constants.size());
  if (m.has_dynamic_body()) bodies.contacts = std::make_shared<RigidContacts>(m);
}

}  // namespace

Bodies::Bodies(const Constants& constants) : cells(constants.model.scene.sort) {
  const BoundarySet& set = constants.model.boundary;
  make_solids(constants.model, *this);
  make_deforming(constants, *this);
  boundary.count = set.count();
  if (boundary.count == 0) return;
  boundary.rest_position = to_device3("drench::boundary_rest_position", set.position);
  boundary.body = to_device<Index>("drench::boundary_body", set.body);
}

void Bodies::upload(const Constants& constants, const HostState& s) {
  const std::size_t bodies = constants.model.bodies.size();
  if (s.body_position.size() != bodies || s.body_orientation.size() != bodies || s.body_velocity.size() != bodies ||
      s.body_angular_velocity.size() != bodies)
    throw std::runtime_error("upload: the state's bodies are not the model's");
  count = static_cast<Index>(bodies);
  moved.advance();
  boundary.count = s.boundary_count();
  if (boundary.count > 0) {
    boundary.position = to_device3("drench::boundary_position", s.boundary_position);
    boundary.velocity = to_device3("drench::boundary_velocity", s.boundary_velocity);
    boundary.volume = to_device<Real>("drench::boundary_volume", s.boundary_volume);
  }
  if (!constants.model.has_body_state()) {
    static_position = s.body_position;
    static_velocity = s.body_velocity;
    static_spin = s.body_angular_velocity;
    static_orientation = s.body_orientation;
    return;
  }
  if (!constant.exists()) make_bodies(constants.model, *this);
  std::vector<RigidState> states;
  for (std::size_t b = 0; b < bodies; ++b) {
    const drench::Quaternion& q = s.body_orientation[b];
    states.push_back({to_double(s.body_position[b]),
                      to_double(s.body_velocity[b]),
                      to_double(s.body_angular_velocity[b]),
                      {q[0], q[1], q[2], q[3]}});
  }
  state = to_device<RigidState>("drench::body_state", states);
  if (dynamic.count > 0) dynamic.predicted = to_device3("drench::body_predicted", s.boundary_velocity);
}

MemoryEstimate body_bytes(const Sizing& m) {
  const double r = m.real;
  double sample = 3 * r + index_bytes;  // rest_position, body
#define DRENCH_BYTES(owner, name, host_type, unit, needed) \
  if (needed) sample += m.entry<host_type>();
  DRENCH_BOUNDARY_FIELDS(DRENCH_BYTES)
#undef DRENCH_BYTES
  if (m.size.dynamic_samples > 0) sample += 3 * r;  // dynamic.predicted
  MemoryEstimate sum;
  sum += deforming_bytes(m);
  sum.bodies += m.size.boundary * sample + (m.size.field + m.size.part_field) * r;
  // sample, owner; position, force, row_load and row_arm, viscous_bound
  sum.bodies += m.size.dynamic_samples * (2 * index_bytes + 9 * r);
  sum.cells = cell_table_bytes(m.size.boundary, m.size.boundary_cells, m);
  return sum;
}

void Bodies::download(const Constants& constants, HostState& s) const {
  s.boundary_position = to_host<Vec3>(boundary.position, boundary.count);
  s.boundary_velocity = to_host<Vec3>(boundary.velocity, boundary.count);
  s.boundary_volume = to_host<double>(boundary.volume, boundary.count);
  download_poses(constants, s);
}

void Bodies::download_poses(const Constants& constants, HostState& s) const {
  s.body_position = static_position;
  s.body_velocity = static_velocity;
  s.body_angular_velocity = static_spin;
  s.body_orientation = static_orientation;
  if (!constants.model.has_body_state()) return;
  for (const RigidState& b : to_host<RigidState>(state, count)) {
    s.body_position.push_back(plain(b.position));
    s.body_velocity.push_back(plain(b.velocity));
    s.body_angular_velocity.push_back(plain(b.spin));
    s.body_orientation.push_back({b.orientation.w, b.orientation.x, b.orientation.y, b.orientation.z});
  }
}

void refresh_boundary_cells(const Constants& constants, Bodies& bodies) {
  if (bodies.cells.is_of(bodies.moved)) return;
  bodies.cells.build(bodies.boundary.position, bodies.boundary.count, constants.support);
  bodies.cells.set_made_from(bodies.moved);
}

void place_solids(const Constants& constants, Bodies& bodies, const StepInfo& info) {
  if (!constants.model.has_moving_body()) return;
  look_for_contacts(bodies, info);
  if (bodies.holding.any) {
    const std::vector<RigidState> ahead = held(bodies, to_host<RigidState>(bodies.state, bodies.count));
    if (!bodies.ahead.exists()) bodies.ahead = to_device<RigidState>("drench::body_end", ahead);
    copy_to_device<RigidState>(bodies.ahead, ahead);
  }
  const Entries<const RigidBody> constant = std::as_const(bodies).constant;
  const Entries<const RigidState> state =
      bodies.holding.any ? std::as_const(bodies).ahead : std::as_const(bodies).state;
  const Entries<Solid> solids = bodies.solids;
  const double dt = info.dt;
  parallel(
      "drench::bodies::solids", static_cast<Index>(bodies.solids.extent(0)), KOKKOS_LAMBDA(const Index k) {
        Solid s = solids(k);
        const RigidBody& body = constant(s.body);
        if (!body.moves) return;
        const RigidState end = moved(state(s.body), dt);
        s.center = narrow(end.position);
        s.point = s.center;
        s.half = narrow(body.half);
        s.velocity = narrow(end.velocity);
        s.spin = narrow(end.spin);
        s.axis[0] = narrow(rotate(end.orientation, {1, 0, 0}));
        s.axis[1] = narrow(rotate(end.orientation, {0, 1, 0}));
        s.axis[2] = narrow(rotate(end.orientation, {0, 0, 1}));
        s.normal = to_world(s, s.rest_normal);
        solids(k) = s;
      });
  place_surfaces(bodies, info);
}

double fastest_body(const Bodies& bodies, double fall) {
  const Entries<const RigidBody> constant = bodies.constant;
  const Entries<const RigidState> state = bodies.state;
  return maximum(
      "drench::time_step::body_speed", bodies.count, KOKKOS_LAMBDA(const Index b) {
        if (!constant(b).moves) return 0.0;
        const RigidState& s = state(b);
        return Kokkos::sqrt(inner(s.velocity, s.velocity)) + Kokkos::sqrt(inner(s.spin, s.spin)) * constant(b).reach +
               (constant(b).dynamic ? fall : 0.0);
      });
}

void sum_sample_forces(Bodies& bodies) {
  const Bodies& b = bodies;
  const Entries<const RigidState> state = b.state;
  const Entries<const Index> owner = b.dynamic.owner;
  const Entries<const Real3> position = b.dynamic.position, force = b.dynamic.force;
  sum_over_samples(
      bodies, KOKKOS_LAMBDA(const Index s) {
        const Double3 f = widen(force(s));
        return Wrench{f, outer(minus(widen(position(s)), state(owner(s)).position), f)};
      });
}

void refresh_dynamic_samples(Bodies& bodies) {
  const Bodies& b = bodies;
  const Entries<const Index> sample = b.dynamic.sample, owner = b.dynamic.owner;
  const Entries<const RigidState> state = b.state;
  const Entries<const Real3> position = b.dynamic.position;
  const Entries<Real3> v = bodies.boundary.velocity;
  parallel(
      "drench::bodies::sample_velocity", b.dynamic.count, KOKKOS_LAMBDA(const Index s) {
        const RigidState& body = state(owner(s));
        v(sample(s)) = narrow(add(body.velocity, outer(body.spin, minus(widen(position(s)), body.position))));
      });
}

void body_stage(Bodies& bodies, double keep, double weight, const Constants* outside) {
  if (bodies.dynamic.count == 0) return;
  sum_sample_forces(bodies);
  move_by_load(bodies, keep, weight, outside);
}

void move_by_load(Bodies& bodies, double keep, double weight, const Constants* outside) {
  const Entries<const RigidBody> constant = std::as_const(bodies).constant;
  const Entries<const Wrench> load = std::as_const(bodies).dynamic.load;
  const Entries<RigidState> state = bodies.state;
  const Entries<Wrench> change = bodies.dynamic.change, inner = bodies.dynamic.inner_change,
                        given = bodies.dynamic.given;
  const Entries<const Wrench> applied = std::as_const(bodies).dynamic.applied;
  const Double3 g = outside ? widen(outside->gravity) : Double3{};
  const bool applies = outside && applied.exist();
  parallel(
      "drench::bodies::velocity", bodies.count, KOKKOS_LAMBDA(const Index b) {
        const RigidBody& body = constant(b);
        if (!body.measured) return;
        const auto changed = [=](const Wrench& by, const Wrench& last) {
          Wrench next{times(weight, by.force), times(weight, by.torque)};
          if (keep > 0) next += Wrench{times(keep, last.force), times(keep, last.torque)};
          return next;
        };
        given(b) += inner(b) = changed(load(b), inner(b));
        if (!body.dynamic) return;
        Wrench whole = load(b);
        whole.force = add(whole.force, times(1 / body.inverse_mass, g));
        if (applies) whole += applied(b);
        const Wrench next = change(b) = changed(whole, change(b));
        RigidState s = state(b);
        s.velocity = add(s.velocity, times(body.inverse_mass, next.force));
        s.spin = add(s.spin, over_inertia(body, s.orientation, next.torque));
        state(b) = s;
      });
  refresh_dynamic_samples(bodies);
}

void look_for_contacts(Bodies& bodies, const StepInfo& info) {
  if (!bodies.contacts) return;
  Holding& h = bodies.holding;
  h.dt = info.dt;
  h.end = info.time + info.dt;
  h.share = info.correction_share;
  if (h.looked_at == bodies.moved) return;  // contacts depend only on where bodies are
  h.any = bodies.contacts->touches(motions_of(to_host<RigidState>(bodies.state, bodies.count)), h.dt, h.end);
  h.looked_at = bodies.moved;
}

std::vector<RigidState> held(const Bodies& bodies, std::vector<RigidState> free) {
  std::vector<RigidMotion> motion = motions_of(free);
  bodies.contacts->hold(motion, bodies.holding.dt, bodies.holding.end, bodies.holding.share);
  for (std::size_t b = 0; b < free.size(); ++b) {
    free[b].velocity = to_double(motion[b].velocity);
    free[b].spin = to_double(motion[b].spin);
  }
  return free;
}

void take_applied(const Constants& constants, Bodies& bodies) {
  std::vector<Wrench> applied;
  bool any = false;
  for (const Body& body : constants.model.bodies) {
    applied.push_back({to_double(body.applied_force), to_double(body.applied_torque)});
    any = any || body.applied_force != Vec3{0, 0, 0} || body.applied_torque != Vec3{0, 0, 0};
  }
  if (any || bodies.dynamic.applied.exists())
    bodies.dynamic.applied = to_device<Wrench>("drench::body_applied", applied);
}

void clear_given(Bodies& bodies) {
  bodies.given_by_cloth.clear();
  bodies.given_by_liquid.clear();
  bodies.given_by_bodies.clear();
  if (bodies.dynamic.count == 0) return;
  const Entries<Wrench> given = bodies.dynamic.given;
  parallel(
      "drench::bodies::clear_given", bodies.count, KOKKOS_LAMBDA(const Index b) { given(b) = {}; });
}

void add_impulses(std::vector<Wrench>& given, const std::vector<Wrench>& impulses) {
  given.resize(impulses.size());
  for (std::size_t b = 0; b < impulses.size(); ++b) given[b] += impulses[b];
}

std::vector<std::optional<BodyLoad>> body_loads(const Constants& constants, const Bodies& bodies, double dt) {
  std::vector<std::optional<BodyLoad>> loads(constants.model.bodies.size());
  if (!constants.model.has_measured_body()) return loads;
  std::vector<Wrench> given(loads.size());
  if (bodies.dynamic.count > 0) given = to_host<Wrench>(bodies.dynamic.given, bodies.count);
  if (!bodies.given_by_liquid.empty()) add_impulses(given, bodies.given_by_liquid);
  for (std::size_t b = 0; b < loads.size(); ++b) {
    if (!constants.model.bodies[b].is_measured()) continue;
    BodyLoad& load = loads[b].emplace();
    if (!(dt > 0)) continue;
    load.liquid_force = plain(times(1 / dt, given[b].force));
    load.liquid_torque = plain(times(1 / dt, given[b].torque));
    if (!bodies.given_by_bodies.empty()) {
      load.contact_force = plain(times(1 / dt, bodies.given_by_bodies[b].force));
      load.contact_torque = plain(times(1 / dt, bodies.given_by_bodies[b].torque));
    }
    if (bodies.given_by_cloth.empty()) continue;
    load.cloth_force = plain(times(1 / dt, bodies.given_by_cloth[b].force));
    load.cloth_torque = plain(times(1 / dt, bodies.given_by_cloth[b].torque));
  }
  return loads;
}

}  // namespace drench::kokkos_backend
