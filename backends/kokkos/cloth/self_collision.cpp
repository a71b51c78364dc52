// Stage self_collision (law: src/stages/self_collision.hpp).

#include "cloth/stages.hpp"

#include "core/host_copy.hpp"
#include "cloth/self_collision_course.hpp"
#include "stages/self_collision.hpp"

namespace drench::kokkos_backend {
namespace {

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

/// The margin of the next step: a larger one finds more pairs, a smaller one finds them more often.
void choose_margin(const Cloth& cloth, SelfCollisionWork& work, bool was_enough) {
  const double least = 0.25 * work.thickness;
  const double most = Kokkos::fmax(least, Kokkos::fmin(3 * least, 0.1 * double(cloth.mesh.mean_edge)));
  work.margin = Kokkos::fmin(most, Kokkos::fmax(least, (was_enough ? 0.9 : 2) * work.margin));
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
  make_room(work.zone, "drench::self_collision::zone", n);
  make_room(work.joined, "drench::self_collision::joined", n);
  make_room(work.stopped, "drench::self_collision::stopped", n);
  make_room(work.holder, "drench::self_collision::holder", n);
  make_room(work.zone_sum, "drench::self_collision::zone_sum", 4 * n);
  make_room(work.zone_push, "drench::self_collision::zone_push", 6 * n);
  allocate_zeros(work.counter, "drench::self_collision::counter", collision_counters);
  choose_margin(cloth, work, true);
}

}  // namespace

MemoryEstimate self_collision_bytes(const Sizing& s) {
  MemoryEstimate sum;
  if (!s.size.self_collision || s.size.nodes <= 0) return sum;
  // As if all cloth took part. A node: velocity, end and seen, impulse, share and node, changed, node_box; of its zone zone,
  // stopped and holder, joined, zone_sum and zone_push
  const double r = s.real, momentum = 3 * sizeof(std::int64_t), zone = 3 * index_bytes + 1 + 10 * sizeof(std::int64_t);
  sum.cloth = s.size.nodes * (3 * double_bytes + 6 * r + momentum + 2 * index_bytes + 1 + 9 * r + zone) +
              s.size.edges * (9 * r + 2 * index_bytes) + s.size.triangles * 3 * index_bytes + close_pair_bytes(s);
  sum.cells = cell_table_bytes(s.size.nodes, 0, s) + cell_table_bytes(s.size.edges, 0, s);
  return sum;
}

Collision::Collision(const Constants& constants, const Bodies& bodies, Cloth& cloth, SelfCollisionWork& work, Real step)
    : position(cloth.nodes.position),
      seen(work.seen),
      end(work.end),
      node_velocity(cloth.nodes.velocity),
      velocity(work.velocity),
      pinned(cloth.nodes.pinned),
      member(work.member),
      inverse_mass(cloth.nodes.inverse_mass),
      materials(node_materials(cloth)),
      solids(bodies.solids),
      pins(cloth),
      wet(constants, cloth),
      impulse(work.impulse),
      share(work.share),
      zone(work.zone),
      stopped(work.stopped),
      holder(work.holder),
      joined(work.joined),
      zone_sum(work.zone_sum),
      zone_push(work.zone_push),
      pair(work.pair),
      distance(work.distance),
      thickness_of(work.thickness_of),
      contact_node(work.contact_node),
      weight(work.weight),
      normal(work.normal),
      target_gap(work.target_gap),
      pair_impulse(work.pair_impulse),
      change(work.change),
      counter(work.counter),
      momentum_unit(constants.quantum / impulse_steps),
      way_unit(double(constants.spacing) / zones::way_units),
      margin(work.margin),
      dt(step),
      nodes(cloth.nodes.count),
      capacity(static_cast<Index>(work.distance.extent(0))) {}

Index Launches::value(const Collision& s, CollisionCounter which) const {
  using Number = Kokkos::MemoryTraits<Kokkos::Unmanaged>;
  Index number = 0;
  Kokkos::deep_copy(Kokkos::View<Index, Kokkos::HostSpace, Number>(&number),
                    Kokkos::View<const Index, MemSpace, Number>(&s.counter.data[which]));
  return number;
}

#ifndef KOKKOS_ENABLE_CUDA
bool prepare_resident_collision(SelfCollisionWork&) { return false; }
CollisionProgress keep_apart_resident(SelfCollisionWork&, const Collision&, const CollisionProgress& at) { return at; }
#endif

void self_collision(const Constants& constants, Bodies& bodies, Cloth& cloth, SelfCollisionWork& work,
                    const StepInfo& info, StepReport& report) {
  const Real dt = static_cast<Real>(info.dt);
  allocate(constants, cloth, work);
  place_solids(constants, bodies, info.dt);
  place_pins(constants, cloth, info);
  refresh_inverse_mass(constants, cloth);
  Launches{}.each<Begin>(Collision(constants, bodies, cloth, work, dt), cloth.nodes.count);
  find_close_pairs(cloth, work);
  const bool resident = prepare_resident_collision(work);
  bool margin_is_enough = true;
  CollisionProgress at;
  while (true) {
    const Collision s(constants, bodies, cloth, work, dt);
    at = resident ? keep_apart_resident(work, s, at) : keep_apart(Launches{}, s, at);
    work.pairs = at.pairs;
    if (at.stop == CollisionProgress::done) break;
    if (at.stop == CollisionProgress::no_room) {
      make_room_for_pairs(work, at.pairs);
      find_close_pairs(cloth, work);
    } else {
      margin_is_enough = false;
      renew_close_pairs(cloth, work);
    }
  }
  choose_margin(cloth, work, margin_is_enough);
  report.cloth_contacts = at.contacts;
  report.cloth_zone_nodes = at.zone_nodes;
}

}  // namespace drench::kokkos_backend
