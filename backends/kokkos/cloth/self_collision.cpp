// Stage self_collision (law: src/stages/self_collision.hpp).

#include "stages/self_collision.hpp"

#include <algorithm>

#include "base/stop_request.hpp"
#include "cloth/clearance.hpp"
#include "cloth/self_collision_course.hpp"
#include "cloth/self_collision_items.hpp"
#include "cloth/stages.hpp"
#include "core/host_copy.hpp"

namespace drench::kokkos_backend {
namespace {

template <class T>
void make_room_for(Field<T>& list, const char* label, Index n) {
  make_ample_room(list, label, static_cast<std::size_t>(n));
}
/// Makes room for what was found.
void make_room_for_pairs(SelfCollisionWork& work, Index close_clusters, Index candidates, Index pairs) {
  make_room_for(work.close_clusters, "drench::self_collision::close_clusters", close_clusters);
  make_room_for(work.candidate, "drench::self_collision::candidate", candidates);
  make_room_for(work.pair, "drench::self_collision::pair", pairs);
  make_room_for(work.hole, "drench::self_collision::hole", pairs);
  make_room_for(work.contact, "drench::self_collision::contact", pairs);
}

/// Of all nodes, with the liquid that fits.
void measure_mass(const Model& model, SelfCollisionWork& work) {
  const std::vector<double>&solid = model.mesh.solid_mass, &capacity = model.samples.node_capacity;
  for (std::size_t n = 0; n < solid.size(); ++n) {
    const double mass = solid[n] + (n < capacity.size() ? capacity[n] : 0);
    work.full_mass += mass;
    work.heaviest_node = std::max(work.heaviest_node, mass);
  }
}

void allocate(const Constants& constants, const Cloth& cloth, SelfCollisionWork& work) {
  if (work.member.extent(0) > 0) return;
  list_items(constants, work);
  const auto n = static_cast<std::size_t>(cloth.nodes.count);
  make_room(work.velocity, "drench::self_collision::velocity", n);
  allocate_zeros(work.end, "drench::self_collision::end", n);
  allocate_zeros(work.seen, "drench::self_collision::seen_end", n);
  make_room(work.changed, "drench::self_collision::changed", n);
  allocate_zeros(work.impulse, "drench::self_collision::impulse", 3 * n);
  allocate_zeros(work.share, "drench::self_collision::share", n);
  make_room(work.zone, "drench::self_collision::zone", n);
  make_room(work.joined, "drench::self_collision::joined", n);
  make_room(work.stopped, "drench::self_collision::stopped", n);
  make_room(work.holder, "drench::self_collision::holder", n);
  make_room(work.zone_sum, "drench::self_collision::zone_sum", 4 * n);
  make_room(work.zone_push, "drench::self_collision::zone_push", 6 * n);
  allocate_zeros(work.counter, "drench::self_collision::counter", collision_counters);
  work.margin = 0.25 * work.thickness;
  measure_mass(constants.model, work);
  make_room_for_pairs(work, 32 * work.items.clusters(), 8 * work.items.count, 8 * work.nodes);
}

}  // namespace

MemoryEstimate self_collision_bytes(const Sizing& s) {
  MemoryEstimate sum;
  if (!s.size.self_collision || s.size.nodes <= 0) return sum;
  // As if all cloth took part. A node: velocity, end and seen, changed, impulse, share; zone, stopped and holder,
  // joined, zone_sum and zone_push
  const double sums = (3 + 10) * sizeof(std::int64_t),
               node = sizeof(NodeVelocity) + 6 * s.real + 5 * index_bytes + 1 + sums;
  const double items = s.size.nodes + s.size.triangles + s.size.edges;
  sum.cloth = s.size.nodes * (node + 1.25 * s.size.fold_pairs * (sizeof(ClosePair) + sizeof(Contact) + index_bytes)) +
              1.25 * items * 9 * sizeof(Couple) + item_bytes(s);
  return sum;
}

Collision::Collision(const Constants& constants, const Bodies& bodies, Cloth& cloth, SelfCollisionWork& work,
                     const StepInfo& info)
    : position(cloth.nodes.position),
      seen(work.seen),
      end(work.end),
      node_velocity(cloth.nodes.velocity),
      velocity(work.velocity),
      pinned(cloth.nodes.pinned),
      member(work.member),
      joint(cloth.nodes.joint),
      changed(work.changed),
      inverse_mass(cloth.nodes.inverse_mass),
      kept(std::as_const(cloth).nodes.clearance),
      piece(work.piece),
      around_start(work.around_start),
      around(work.around),
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
      corner(work.items.corner),
      rank(work.items.rank),
      group_pair(work.items.group_pair),
      box(work.items.box),
      close_clusters(work.close_clusters),
      candidate(work.candidate),
      items(work.items.count),
      clusters(work.items.clusters()),
      groups(work.items.groups()),
      group_pairs(static_cast<Index>(work.items.group_pair.extent(0))),
      first_triangle(work.items.first_triangle),
      cluster_room(static_cast<Index>(work.close_clusters.extent(0))),
      candidate_room(static_cast<Index>(work.candidate.extent(0))),
      pair_room(static_cast<Index>(work.pair.extent(0))),
      pair(work.pair),
      hole(work.hole),
      contact(work.contact),
      counter(work.counter),
      momentum_unit(work.heaviest_node * impulse_part),
      way_unit(double(constants.spacing) / zones::way_units),
      margin(work.margin),
      full_mass(work.full_mass),
      parting(0.1 * info.correction_share),
      dt(static_cast<Real>(info.dt)),
      half_reach(static_cast<Real>(0.50001 * (work.thickness + 2 * work.margin))),
      nodes(cloth.nodes.count) {}

Index Launches::value(const Collision& s, CollisionCounter which) const {
  stop_if_requested();
  using Number = Kokkos::MemoryTraits<Kokkos::Unmanaged>;
  Index number = 0;
  copy_now(Kokkos::View<Index, Kokkos::HostSpace, Number>(&number),
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
  place_solids(constants, bodies, info);
  set_clearance(constants, bodies, cloth, dt);
  place_pins(constants, cloth, info);
  refresh_inverse_mass(constants, cloth);
  const bool resident = prepare_resident_collision(work);
  CollisionProgress at;
  while (!at.done) {
    make_room_for_pairs(work, at.close_clusters, at.candidates, at.pairs);
    const Collision s(constants, bodies, cloth, work, info);
    at = resident ? keep_apart_resident(work, s, at) : keep_apart(Launches{}, s, at);
  }
  work.found_pairs = at.pairs;
  report.cloth_contacts = at.contacts;
  report.cloth_zone_nodes = at.zone_nodes;
}

}  // namespace drench::kokkos_backend
