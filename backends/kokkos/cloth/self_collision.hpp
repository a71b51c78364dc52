#pragma once
// Work arrays of stage self_collision, made on first use, and its parts. Law: src/stages/self_collision.hpp.

#include <memory>

#include "cloth/cloth.hpp"

namespace drench::kokkos_backend {

constexpr Index no_node = 2147483647;
constexpr Index pair_of_node = 0, pair_of_edges = 1, dropped_pair = 2;  // node and triangle; two edges; none any more

/// What SelfCollisionWork::counter counts. `ends_moved` is a flag: an end has moved by more than the search's margin.
enum CollisionCounter : Index { count_pairs, count_contacts, ends_moved, count_zone_nodes, collision_counters };

/// How far paths reach from their centres, and the box around them, m.
struct PathSizes {
  double half = 0;
  PointBounds bounds;
};

struct SelfCollisionWork {
  // the cloths that take part
  Field<Index> node, triangle, edge;  // node numbers: 1, 3 and 2 each
  Field<std::uint8_t> member;         // per node of all cloths
  Index nodes = 0, triangles = 0, edges = 0;
  double thickness = 0;  // m: the largest
  // per node of all cloths
  Field<double> velocity;         // 3 each, m/s
  Field<Real3> end, seen;         // x¹, m; the same when the node's pairs were found
  Field<std::uint8_t> changed;    // its pairs are to be found again
  Field<std::uint8_t> marked;     // per bucket of node_cells: one of its nodes has changed
  Field<std::int64_t> impulse;    // 3 each, units of q · 2^-20 m/s; 0 between passes
  Field<Index> share;             // N_k; 0 between passes
  // per node of all cloths, of law 4: made when a zone begins, meaningless before
  Field<Index> zone;              // the zone's least node
  Field<std::uint8_t> joined;     // is in a zone
  Field<Index> stopped;           // at a zone's least node: 1 is to stop, 2 has stopped
  Field<Index> holder;            // at a zone's least node: the first pinned node of the zone, or no_node
  Field<std::int64_t> zone_sum;   // 4 each, at the least node: mass, q · 2^-16; momentum, q · 2^-12 m/s
  Field<std::int64_t> zone_push;  // 6 each: the largest way out of bodies along +x −x +y …, d · 2^-40
  // candidates
  Field<Real3> node_center, edge_center, node_lo, node_hi, edge_lo, edge_hi;  // of the paths' boxes, m
  Kokkos::View<PathSizes, Kokkos::SharedHostPinnedSpace> node_sizes, edge_sizes;
  CellTable node_cells, edge_cells;
  double margin = 0;             // m: by how much an end may move before its pairs are found again
  Index pairs = 0;               // as far as the host knows
  Field<Index> pair;             // 5 each: four nodes; what they are
  Field<double> distance;        // δ⁰, m
  Field<double> thickness_of;    // τ, m
  // contacts of law 3, a list of its own in each round; law 4 puts the pairs that violate into contact_node
  Field<Index> contact_node;     // 4 each
  Field<double> weight, normal;  // 4 and 3 each
  Field<double> target_gap, pair_impulse;  // γ, m; λ, kg m/s
  Field<double> change;          // the missing gap of the pass, m
  Field<Index> counter;          // CollisionCounter
  std::shared_ptr<struct ResidentCollision> resident;  // of CUDA (cloth/cuda/resident_collision.cpp)
};

MemoryEstimate self_collision_bytes(const Sizing& s);
/// Of the candidates' part (self_collision_pairs.cpp).
double close_pair_bytes(const Sizing& s);

/// Finds all pairs that can come nearer than τ while no end moves by more than work.margin. Their number is in
/// work.counter; if there is no room for so many, some are missing.
void find_close_pairs(const Cloth& cloth, SelfCollisionWork& work);
/// The same where ends have moved since: finds the pairs of those nodes again that have by more than the margin, if these are
/// few. Synchronises with the host.
void renew_close_pairs(const Cloth& cloth, SelfCollisionWork& work);
/// Makes room for so many pairs, and a quarter more.
void make_room_for_pairs(SelfCollisionWork& work, Index pairs);

}  // namespace drench::kokkos_backend
