// Stage self_collision (law: src/stages/self_collision.hpp).

#include "self_collision.hpp"

#include "device_copy.hpp"
#include "laws/contact.hpp"
#include "laws/proximity.hpp"
#include "laws/wet_cloth.hpp"
#include "pins.hpp"
#include "rigid_bodies.hpp"
#include "self_collision_zones.hpp"
#include "stages/self_collision.hpp"

namespace drench::kokkos_backend {
namespace {

constexpr int rounds = 3, passes = 8;
constexpr double impulse_units = 1048576;  // per quantum · m/s

/// Which nodes, triangles and edges take part.
void list_members(Device& d) {
  SelfCollisionWork& w = d.self_collision_work;
  const ClothMesh& mesh = d.model.mesh;
  const auto takes_part = [&](Index node) {
    return d.model.cloths[static_cast<std::size_t>(mesh.node_cloth[static_cast<std::size_t>(node)])].self_collision;
  };
  std::vector<Index> nodes, triangles, edges;
  std::vector<std::uint8_t> member;
  for (Index n = 0; n < mesh.nodes(); ++n) {
    member.push_back(takes_part(n) ? 1 : 0);
    if (takes_part(n)) nodes.push_back(n);
  }
  for (const auto& t : mesh.triangle)
    if (takes_part(t[0])) triangles.insert(triangles.end(), t.begin(), t.end());
  for (const auto& e : mesh.edge)
    if (takes_part(e[0])) edges.insert(edges.end(), e.begin(), e.end());
  for (const ClothMaterial& c : d.model.cloths)
    if (c.self_collision) w.thickness = Kokkos::fmax(w.thickness, c.thickness);
  w.nodes = static_cast<Index>(nodes.size());
  w.triangles = static_cast<Index>(triangles.size() / 3);
  w.edges = static_cast<Index>(edges.size() / 2);
  w.member = to_device<std::uint8_t>("drench::self_collision::member", member);
  w.node = to_device<Index>("drench::self_collision::node", nodes);
  w.triangle = to_device<Index>("drench::self_collision::triangle", triangles);
  w.edge = to_device<Index>("drench::self_collision::edge", edges);
}

void allocate(Device& d) {
  SelfCollisionWork& w = d.self_collision_work;
  if (w.member.extent(0) > 0) return;
  list_members(d);
  const auto n = static_cast<std::size_t>(d.nodes.count);
  w.velocity = Array<double>("drench::self_collision::velocity", 3 * n);
  w.end = Array<Real3>("drench::self_collision::end", n);
  w.seen = Array<Real3>("drench::self_collision::seen_end", n);
  w.changed = Array<std::uint8_t>("drench::self_collision::changed", n);
  w.impulse = Array<std::int64_t>("drench::self_collision::impulse", 3 * n);
  w.share = Array<Index>("drench::self_collision::share", n);
  for (Array<Real3>* a : {&w.node_center, &w.node_lo, &w.node_hi})
    *a = Array<Real3>("drench::self_collision::node_box", static_cast<std::size_t>(w.nodes));
  for (Array<Real3>* a : {&w.edge_center, &w.edge_lo, &w.edge_hi})
    *a = Array<Real3>("drench::self_collision::edge_box", static_cast<std::size_t>(w.edges));
  w.count = Kokkos::View<Index, MemSpace>("drench::self_collision::count");
}

/// Law 1, and x¹ exactly as stage advection will round it.
struct Placing {
  Array<Real3> position, end;
  Array<double> velocity;
  Array<std::uint8_t> pinned, member;
  Array<Index> cloth;
  Array<Material> materials;
  Array<Solid> solids;
  PinMotions pins;
  Real dt;

  Placing(const Device& d, Real step)
      : position(d.nodes.position),
        end(d.self_collision_work.end),
        velocity(d.self_collision_work.velocity),
        pinned(d.nodes.pinned),
        member(d.self_collision_work.member),
        cloth(d.nodes.cloth),
        materials(d.materials),
        solids(d.solids),
        pins(d),
        dt(step) {}

  KOKKOS_INLINE_FUNCTION void operator()(Index n, Double3 w) const {
    const Real3 x = position(n);
    if (pinned(n) || !member(n)) {
      end(n) = pinned(n) && pins.moves(n) ? pins.position(n) : x;
      w = times(1 / double(dt), minus(widen(end(n)), widen(x)));
    } else {
      Real3 shift = dt * narrow(w);
      const Real3 out = project_out(solids, x, shift, materials(cloth(n)).thickness);
      if (out.x != shift.x || out.y != shift.y || out.z != shift.z) {
        const Real3 v = (1 / dt) * out;
        w = widen(v);
        shift = dt * v;
      }
      end(n) = x + shift;
    }
    velocity(3 * n) = w.x;
    velocity(3 * n + 1) = w.y;
    velocity(3 * n + 2) = w.z;
  }
};

void begin(Device& d, Real dt) {
  const Placing place(d, dt);
  const auto velocity = d.nodes.velocity;
  parallel(
      "drench::self_collision::begin", d.nodes.count, KOKKOS_LAMBDA(const Index n) { place(n, widen(velocity(n))); });
}

/// What the kernels over pairs see.
struct Pairs {
  Array<Index> pair, share;
  Array<Real3> position, end;
  Array<double> velocity, distance, thickness_of, weight, normal, goal, strength, change;
  Array<std::uint8_t> contact;
  Array<std::int64_t> impulse;
  Array<Real> inverse_mass;
  Array<Index> cloth;
  Array<Material> materials;
  Array<Quanta> liquid;
  Array<double> capacity;
  double quantum, dt, momentum_unit;  // kg; s; kg m/s

  Pairs(const Device& d, double step)
      : pair(d.self_collision_work.pair),
        share(d.self_collision_work.share),
        position(d.nodes.position),
        end(d.self_collision_work.end),
        velocity(d.self_collision_work.velocity),
        distance(d.self_collision_work.distance),
        thickness_of(d.self_collision_work.thickness_of),
        weight(d.self_collision_work.weight),
        normal(d.self_collision_work.normal),
        goal(d.self_collision_work.goal),
        strength(d.self_collision_work.strength),
        change(d.self_collision_work.change),
        contact(d.self_collision_work.contact),
        impulse(d.self_collision_work.impulse),
        inverse_mass(d.nodes.inverse_mass),
        cloth(d.nodes.cloth),
        materials(d.materials),
        liquid(d.nodes.liquid),
        capacity(d.nodes.capacity),
        quantum(d.quantum),
        dt(step),
        momentum_unit(d.quantum / impulse_units) {}

  KOKKOS_INLINE_FUNCTION Double3 normal_of(Index p) const {
    return {normal(3 * p), normal(3 * p + 1), normal(3 * p + 2)};
  }
  KOKKOS_INLINE_FUNCTION Double3 velocity_of(Index n) const {
    return {velocity(3 * n), velocity(3 * n + 1), velocity(3 * n + 2)};
  }
  /// n·Σ b x¹ with x¹ not yet rounded, m.
  KOKKOS_INLINE_FUNCTION double gap(Index p) const {
    const Double3 n = normal_of(p), origin = widen(position(pair(5 * p)));
    double sum = 0;
    for (int k = 0; k < 4; ++k) {
      const Index node = pair(5 * p + k);
      sum += weight(4 * p + k) * inner(n, add(minus(widen(position(node)), origin), times(dt, velocity_of(node))));
    }
    return sum;
  }
  /// Σ b² c/m, 1/kg.
  KOKKOS_INLINE_FUNCTION double inverse(Index p) const {
    double sum = 0;
    for (int k = 0; k < 4; ++k) {
      const Index node = pair(5 * p + k);
      const double b = weight(4 * p + k);
      sum += b * b * double(share(node)) * double(inverse_mass(node));
    }
    return sum;
  }
  /// μ of the cloth at node n, as wet as it is there.
  KOKKOS_INLINE_FUNCTION double friction(Index n) const {
    const Material& m = materials(cloth(n));
    return double(at_saturation(m.friction, m.friction_wet, node_saturation(liquid(n), quantum, capacity(n))));
  }
  KOKKOS_INLINE_FUNCTION void count_in(Index p) const {
    for (int k = 0; k < 4; ++k)
      if (weight(4 * p + k) != 0) Kokkos::atomic_add(&share(pair(5 * p + k)), Index{1});
  }
  KOKKOS_INLINE_FUNCTION void push(Index p, const Double3& j) const {
    for (int k = 0; k < 4; ++k) {
      const double scale = weight(4 * p + k) / momentum_unit;
      const Index at = 3 * pair(5 * p + k);
      if (scale == 0) continue;
      Kokkos::atomic_add(&impulse(at), static_cast<std::int64_t>(Kokkos::floor(scale * j.x + 0.5)));
      Kokkos::atomic_add(&impulse(at + 1), static_cast<std::int64_t>(Kokkos::floor(scale * j.y + 0.5)));
      Kokkos::atomic_add(&impulse(at + 2), static_cast<std::int64_t>(Kokkos::floor(scale * j.z + 0.5)));
    }
  }
};

/// Law 3: who is in contact, and how. Returns their number; synchronises with the host.
std::int64_t find_contacts(const Pairs& s, Index pairs) {
  std::int64_t contacts = 0;
  Kokkos::parallel_reduce(
      "drench::self_collision::contacts", Range(0, pairs),
      KOKKOS_LAMBDA(const Index p, std::int64_t& sum) {
        s.contact(p) = 0;
        const Index kind = s.pair(5 * p + 4);
        if (kind == dropped_pair) return;
        Double3 x[4], u[4];
        for (int k = 0; k < 4; ++k) {
          const Index n = s.pair(5 * p + k);
          x[k] = widen(s.position(n));
          u[k] = minus(widen(s.end(n)), x[k]);
        }
        const bool edges = kind == pair_of_edges;
        const double tau = s.thickness_of(p), start = s.distance(p);
        Proximity near;
        bool touches = start <= tau;
        if (touches)
          near = proximity(edges, x);
        else
          touches = reaches(edges, x, u, tau, near);
        if (!(near.distance > 0)) touches = false;
        if (!touches) return;
        s.contact(p) = 1;
        for (int k = 0; k < 4; ++k) s.weight(4 * p + k) = near.b[k];
        s.normal(3 * p) = near.apart.x / near.distance;
        s.normal(3 * p + 1) = near.apart.y / near.distance;
        s.normal(3 * p + 2) = near.apart.z / near.distance;
        s.goal(p) = Kokkos::fmin(tau, start < tau ? start + 0.1 * tau : tau);
        s.strength(p) = 0;
        ++sum;
      },
      contacts);
  return contacts;
}

/// Adds the impulses to the velocities and clears the sums.
void apply_impulses(const Device& d, const Pairs& s, Real dt) {
  const Placing place(d, dt);
  parallel(
      "drench::self_collision::apply", d.nodes.count, KOKKOS_LAMBDA(const Index n) {
        if (s.share(n) == 0) return;
        const double unit = s.momentum_unit * double(s.inverse_mass(n));
        const Double3 p{double(s.impulse(3 * n)), double(s.impulse(3 * n + 1)), double(s.impulse(3 * n + 2))};
        place(n, add(s.velocity_of(n), times(unit, p)));
        for (int a = 0; a < 3; ++a) s.impulse(3 * n + a) = 0;
        s.share(n) = 0;
      });
}

/// Law 3, one pass over the contacts.
void push_apart(const Device& d, const Pairs& s, Index pairs, Real dt) {
  parallel(
      "drench::self_collision::gap", pairs, KOKKOS_LAMBDA(const Index p) {
        s.change(p) = 0;
        if (!s.contact(p)) return;
        const double missing = s.goal(p) - s.gap(p);
        if (!(missing > 0) && !(s.strength(p) > 0)) return;
        s.change(p) = missing;
        s.count_in(p);
      });
  parallel(
      "drench::self_collision::push", pairs, KOKKOS_LAMBDA(const Index p) {
        if (s.change(p) == 0) return;
        const double inverse = s.inverse(p);
        if (!(inverse > 0)) return;
        const double before = s.strength(p), after = Kokkos::fmax(0.0, before + s.change(p) / (s.dt * inverse));
        s.strength(p) = after;
        s.push(p, times(after - before, s.normal_of(p)));
      });
  apply_impulses(d, s, dt);
}

/// Law 3, friction.
void rub(const Device& d, const Pairs& s, Index pairs, Real dt) {
  parallel(
      "drench::self_collision::pressed", pairs, KOKKOS_LAMBDA(const Index p) {
        if (s.contact(p) && s.strength(p) > 0) s.count_in(p);
      });
  parallel(
      "drench::self_collision::friction", pairs, KOKKOS_LAMBDA(const Index p) {
        if (!s.contact(p) || !(s.strength(p) > 0)) return;
        const double mu = 0.5 * (s.friction(s.pair(5 * p)) + s.friction(s.pair(5 * p + 3)));
        const double inverse = s.inverse(p);
        Double3 u;
        for (int k = 0; k < 4; ++k) u = add(u, times(s.weight(4 * p + k), s.velocity_of(s.pair(5 * p + k))));
        const Double3 n = s.normal_of(p);
        u = minus(u, times(inner(u, n), n));
        const double speed = Kokkos::sqrt(inner(u, u));
        if (!(speed > 0) || !(inverse > 0)) return;
        s.push(p, times(-Kokkos::fmin(mu * s.strength(p), speed / inverse) / speed, u));
      });
  apply_impulses(d, s, dt);
}

void finish(Device& d) {
  const auto velocity = d.nodes.velocity;
  const auto member = d.self_collision_work.member, pinned = d.nodes.pinned;
  const auto w = d.self_collision_work.velocity;
  parallel(
      "drench::self_collision::velocity", d.nodes.count, KOKKOS_LAMBDA(const Index n) {
        if (member(n) && !pinned(n)) velocity(n) = narrow({w(3 * n), w(3 * n + 1), w(3 * n + 2)});
      });
}

}  // namespace

void self_collision(Device& d, const StepInfo& info, StepReport& report) {
  const Real dt = static_cast<Real>(info.dt);
  allocate(d);
  place_solids(d, info.dt);
  place_pins(d, info);
  refresh_inverse_mass(d);
  begin(d, dt);
  SelfCollisionWork& w = d.self_collision_work;
  const double margin = 0.25 * w.thickness;
  find_close_pairs(d, margin);
  const auto renew = [&] { renew_close_pairs(d, margin); };
  report.cloth_contacts = 0;
  report.cloth_zone_nodes = 0;
  for (int round = 0; round < rounds && w.pairs > 0; ++round) {
    if (round > 0) renew();
    const Pairs pairs(d, static_cast<double>(dt));
    const std::int64_t contacts = find_contacts(pairs, w.pairs);
    if (contacts == 0) break;
    if (round == 0) report.cloth_contacts = contacts;
    for (int pass = 0; pass < passes; ++pass) push_apart(d, pairs, w.pairs, dt);
    rub(d, pairs, w.pairs, dt);
  }
  if (report.cloth_contacts > 0) report.cloth_zone_nodes = join_zones(d, dt, renew);
  finish(d);
}

}  // namespace drench::kokkos_backend
