// Stage self_collision (law: src/stages/self_collision.hpp).

#include "cloth/stages.hpp"

#include "core/fixed_point.hpp"
#include "core/host_copy.hpp"
#include "bodies/contact.hpp"
#include "cloth/proximity.hpp"
#include "cloth/wet_cloth.hpp"
#include "cloth/pins.hpp"
#include "cloth/self_collision_zones.hpp"
#include "stages/self_collision.hpp"

namespace drench::kokkos_backend {
namespace {

constexpr int rounds = 3, passes = 8;

/// Which nodes, triangles and edges take part.
void list_members(const Constants& constants, SelfCollisionWork& work) {
  const ClothMesh& mesh = constants.model.mesh;
  const auto takes_part = [&](Index node) {
    return constants.model.cloths[static_cast<std::size_t>(mesh.node_cloth[static_cast<std::size_t>(node)])].self_collision;
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
  for (const ClothMaterial& c : constants.model.cloths)
    if (c.self_collision) work.thickness = Kokkos::fmax(work.thickness, c.thickness);
  work.nodes = static_cast<Index>(nodes.size());
  work.triangles = static_cast<Index>(triangles.size() / 3);
  work.edges = static_cast<Index>(edges.size() / 2);
  work.member = to_device<std::uint8_t>("drench::self_collision::member", member);
  work.node = to_device<Index>("drench::self_collision::node", nodes);
  work.triangle = to_device<Index>("drench::self_collision::triangle", triangles);
  work.edge = to_device<Index>("drench::self_collision::edge", edges);
}

void allocate(const Constants& constants, const Cloth& cloth, SelfCollisionWork& work) {
  if (work.member.extent(0) > 0) return;
  list_members(constants, work);
  const auto n = static_cast<std::size_t>(cloth.nodes.count);
  allocate_zeros(work.velocity, "drench::self_collision::velocity", 3 * n);
  allocate_zeros(work.end, "drench::self_collision::end", n);
  allocate_zeros(work.seen, "drench::self_collision::seen_end", n);
  allocate_zeros(work.changed, "drench::self_collision::changed", n);
  allocate_zeros(work.impulse, "drench::self_collision::impulse", 3 * n);
  allocate_zeros(work.share, "drench::self_collision::share", n);
  for (Field<Real3>* a : {&work.node_center, &work.node_lo, &work.node_hi})
    allocate_zeros(*a, "drench::self_collision::node_box", static_cast<std::size_t>(work.nodes));
  for (Field<Real3>* a : {&work.edge_center, &work.edge_lo, &work.edge_hi})
    allocate_zeros(*a, "drench::self_collision::edge_box", static_cast<std::size_t>(work.edges));
  work.count = Kokkos::View<Index, MemSpace>("drench::self_collision::count");
}

}  // namespace

MemoryEstimate self_collision_bytes(const Sizing& s) {
  MemoryEstimate sum;
  if (!s.size.self_collision || s.size.nodes <= 0) return sum;
  // As if all cloth took part. A node: velocity, end and seen, impulse, share and node, changed, node_box
  const double r = s.real, momentum = 3 * sizeof(std::int64_t);
  sum.cloth = s.size.nodes * (3 * double_bytes + 6 * r + momentum + 2 * index_bytes + 1 + 9 * r) +
              s.size.edges * (9 * r + 2 * index_bytes) + s.size.triangles * 3 * index_bytes + close_pair_bytes(s);
  sum.cells = cell_table_bytes(s.size.nodes, 0, s) + cell_table_bytes(s.size.edges, 0, s);
  return sum;
}

namespace {

/// Law 1, and x¹ exactly as stage advection will round it.
struct Placing {
  Entries<const Real3> position;
  Entries<Real3> end;
  Entries<double> velocity;
  Slice<const std::uint8_t> pinned, member;
  Materials materials;
  Slice<const Solid> solids;
  PinMotions pins;
  Real dt;

  Placing(const Bodies& bodies, const Cloth& fabric, SelfCollisionWork& work, Real step)
      : position(fabric.nodes.position),
        end(work.end),
        velocity(work.velocity),
        pinned(fabric.nodes.pinned),
        member(work.member),
        materials(node_materials(fabric)),
        solids(bodies.solids),
        pins(fabric),
        dt(step) {}

  KOKKOS_INLINE_FUNCTION void operator()(Index n, Double3 w) const {
    const Real3 x = position(n);
    if (pinned(n) || !member(n)) {
      end(n) = pinned(n) && pins.moves(n) ? pins.position(n) : x;
      w = times(1 / double(dt), minus(widen(end(n)), widen(x)));
    } else {
      Real3 shift = dt * narrow(w);
      const Real3 out = project_out(solids, x, shift, materials(n).thickness);
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

void begin(const Bodies& bodies, const Cloth& cloth, SelfCollisionWork& work, Real dt) {
  const Placing place(bodies, cloth, work, dt);
  const Entries<const Real3> velocity = cloth.nodes.velocity;
  parallel(
      "drench::self_collision::begin", cloth.nodes.count, KOKKOS_LAMBDA(const Index n) { place(n, widen(velocity(n))); });
}

/// What the kernels over pairs see.
struct Pairs {
  Entries<const Index> pair;
  Entries<Index> share;
  Entries<const Real3> position;
  Entries<Real3> end;
  Entries<const double> distance, thickness_of;
  Entries<double> velocity, weight, normal, target_gap, pair_impulse, change;
  Entries<std::uint8_t> contact;
  Entries<std::int64_t> impulse;
  Entries<const Real> inverse_mass;
  Materials materials;
  NodeLiquid wet;
  double dt, momentum_unit;  // s; kg m/s

  Pairs(const Constants& constants, const Cloth& fabric, SelfCollisionWork& work, double step)
      : pair(work.pair),
        share(work.share),
        position(fabric.nodes.position),
        end(work.end),
        distance(work.distance),
        thickness_of(work.thickness_of),
        velocity(work.velocity),
        weight(work.weight),
        normal(work.normal),
        target_gap(work.target_gap),
        pair_impulse(work.pair_impulse),
        change(work.change),
        contact(work.contact),
        impulse(work.impulse),
        inverse_mass(fabric.nodes.inverse_mass),
        materials(node_materials(fabric)),
        wet(constants, fabric),
        dt(step),
        momentum_unit(constants.quantum / impulse_steps) {}

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
  KOKKOS_INLINE_FUNCTION double friction(Index n) const { return double(friction_at(materials(n), wet, n)); }
  KOKKOS_INLINE_FUNCTION void count_in(Index p) const {
    for (int k = 0; k < 4; ++k)
      if (weight(4 * p + k) != 0) Kokkos::atomic_add(&share(pair(5 * p + k)), Index{1});
  }
  KOKKOS_INLINE_FUNCTION void push(Index p, const Double3& j) const {
    for (int k = 0; k < 4; ++k) {
      const double scale = weight(4 * p + k) / momentum_unit;
      if (scale == 0) continue;
      add_fixed(impulse, pair(5 * p + k), times(scale, j));
    }
  }
};

/// Law 3: who is in contact, and how. Returns their number; synchronises with the host.
std::int64_t find_contacts(const Pairs& s, Index pairs) {
  std::int64_t contacts = 0;
  Kokkos::parallel_reduce(
      "drench::self_collision::contacts", range(pairs),
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
        s.target_gap(p) = Kokkos::fmin(tau, start < tau ? start + 0.1 * tau : tau);
        s.pair_impulse(p) = 0;
        ++sum;
      },
      contacts);
  return contacts;
}

/// Adds the impulses to the velocities and clears the sums.
void apply_impulses(const Bodies& bodies, const Cloth& cloth, SelfCollisionWork& work, const Pairs& s, Real dt) {
  const Placing place(bodies, cloth, work, dt);
  parallel(
      "drench::self_collision::apply", cloth.nodes.count, KOKKOS_LAMBDA(const Index n) {
        if (s.share(n) == 0) return;
        const double unit = s.momentum_unit * double(s.inverse_mass(n));
        const Double3 p{double(s.impulse(3 * n)), double(s.impulse(3 * n + 1)), double(s.impulse(3 * n + 2))};
        place(n, add(s.velocity_of(n), times(unit, p)));
        for (int a = 0; a < 3; ++a) s.impulse(3 * n + a) = 0;
        s.share(n) = 0;
      });
}

/// Law 3, one pass over the contacts.
void push_apart(const Bodies& bodies, const Cloth& cloth, SelfCollisionWork& work, const Pairs& s, Index pairs, Real dt) {
  parallel(
      "drench::self_collision::gap", pairs, KOKKOS_LAMBDA(const Index p) {
        s.change(p) = 0;
        if (!s.contact(p)) return;
        const double missing = s.target_gap(p) - s.gap(p);
        if (!(missing > 0) && !(s.pair_impulse(p) > 0)) return;
        s.change(p) = missing;
        s.count_in(p);
      });
  parallel(
      "drench::self_collision::push", pairs, KOKKOS_LAMBDA(const Index p) {
        if (s.change(p) == 0) return;
        const double inverse = s.inverse(p);
        if (!(inverse > 0)) return;
        const double before = s.pair_impulse(p), after = Kokkos::fmax(0.0, before + s.change(p) / (s.dt * inverse));
        s.pair_impulse(p) = after;
        s.push(p, times(after - before, s.normal_of(p)));
      });
  apply_impulses(bodies, cloth, work, s, dt);
}

/// Law 3, friction.
void apply_friction(const Bodies& bodies, const Cloth& cloth, SelfCollisionWork& work, const Pairs& s, Index pairs, Real dt) {
  parallel(
      "drench::self_collision::pressed", pairs, KOKKOS_LAMBDA(const Index p) {
        if (s.contact(p) && s.pair_impulse(p) > 0) s.count_in(p);
      });
  parallel(
      "drench::self_collision::friction", pairs, KOKKOS_LAMBDA(const Index p) {
        if (!s.contact(p) || !(s.pair_impulse(p) > 0)) return;
        const double mu = 0.5 * (s.friction(s.pair(5 * p)) + s.friction(s.pair(5 * p + 3)));
        const double inverse = s.inverse(p);
        Double3 u;
        for (int k = 0; k < 4; ++k) u = add(u, times(s.weight(4 * p + k), s.velocity_of(s.pair(5 * p + k))));
        const Double3 n = s.normal_of(p);
        u = minus(u, times(inner(u, n), n));
        const double speed = Kokkos::sqrt(inner(u, u));
        if (!(speed > 0) || !(inverse > 0)) return;
        s.push(p, times(-Kokkos::fmin(mu * s.pair_impulse(p), speed / inverse) / speed, u));
      });
  apply_impulses(bodies, cloth, work, s, dt);
}

void finish(Cloth& cloth, const SelfCollisionWork& work) {
  const Entries<Real3> velocity = cloth.nodes.velocity;
  const Entries<const std::uint8_t> member = work.member, pinned = cloth.nodes.pinned;
  const Entries<const double> w = work.velocity;
  parallel(
      "drench::self_collision::velocity", cloth.nodes.count, KOKKOS_LAMBDA(const Index n) {
        if (member(n) && !pinned(n)) velocity(n) = narrow({w(3 * n), w(3 * n + 1), w(3 * n + 2)});
      });
}

}  // namespace

void self_collision(const Constants& constants, Bodies& bodies, Cloth& cloth, SelfCollisionWork& work,
                    const StepInfo& info, StepReport& report) {
  const Real dt = static_cast<Real>(info.dt);
  allocate(constants, cloth, work);
  place_solids(constants, bodies, info.dt);
  place_pins(constants, cloth, info);
  refresh_inverse_mass(constants, cloth);
  begin(bodies, cloth, work, dt);
  const double margin = 0.25 * work.thickness;
  find_close_pairs(cloth, work, margin);
  const auto renew = [&] { renew_close_pairs(cloth, work, margin); };
  report.cloth_contacts = 0;
  report.cloth_zone_nodes = 0;
  for (int round = 0; round < rounds && work.pairs > 0; ++round) {
    if (round > 0) renew();
    const Pairs pairs(constants, cloth, work, static_cast<double>(dt));
    const std::int64_t contacts = find_contacts(pairs, work.pairs);
    if (contacts == 0) break;
    if (round == 0) report.cloth_contacts = contacts;
    for (int pass = 0; pass < passes; ++pass) push_apart(bodies, cloth, work, pairs, work.pairs, dt);
    apply_friction(bodies, cloth, work, pairs, work.pairs, dt);
  }
  if (report.cloth_contacts > 0) report.cloth_zone_nodes = join_zones(constants, bodies, cloth, work, dt, renew);
  finish(cloth, work);
}

}  // namespace drench::kokkos_backend
