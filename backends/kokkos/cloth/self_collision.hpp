#pragma once
// Work arrays of stage self_collision, made on first use, and its parts. Law: src/stages/self_collision.hpp.

#include <memory>

#include "cloth/cloth.hpp"
#include "core/double3.hpp"

namespace drench::kokkos_backend {

constexpr Index no_node = 2147483647, dropped_pair = 2;

/// What SelfCollisionWork::counter counts. New pairs fill the holes that dropped ones leave and then follow the others,
/// which count_pairs has not. `ends_moved` is a flag: an end has moved by more than the search's margin.
enum CollisionCounter : Index {
  count_changed,
  count_close_clusters,
  count_candidates,
  count_holes,
  count_new,
  count_pairs,
  count_contacts,
  ends_moved,
  count_zone_nodes,
  collision_counters
};

/// A velocity, m/s, in two loads.
struct alignas(4 * sizeof(double)) NodeVelocity : Double3 {};

/// A box of paths, m, in two loads; empty as it is made. lo.w: 1 if one of the paths is to be searched for, else 0.
struct PathBox {
  static constexpr Real far = Kokkos::Experimental::finite_max_v<Real>;
  Real4 lo{{far, far, far}, 0}, hi{{-far, -far, -far}, 0};

  KOKKOS_INLINE_FUNCTION void add(const PathBox& o) {
    lo = {{smaller(lo.x, o.lo.x), smaller(lo.y, o.lo.y), smaller(lo.z, o.lo.z)}, larger(lo.w, o.lo.w)};
    hi = {{larger(hi.x, o.hi.x), larger(hi.y, o.hi.y), larger(hi.z, o.hi.z)}, 0};
  }
  /// Do they meet, and is one of them searched for?
  KOKKOS_INLINE_FUNCTION bool meets(const PathBox& o) const {
    // Bitwise: whether two boxes meet cannot be predicted, and a wrong guess costs more than six comparisons.
    return ((lo.w > 0) | (o.lo.w > 0)) & (lo.x <= o.hi.x) & (o.lo.x <= hi.x) & (lo.y <= o.hi.y) & (o.lo.y <= hi.y) &
           (lo.z <= o.hi.z) & (o.lo.z <= hi.z);
  }
};

/// Two boxes, clusters of boxes or groups of clusters.
struct alignas(2 * sizeof(Index)) Couple {
  Index first, second;
};

/// A node and a triangle, or two edges.
struct alignas(16) ClosePair {
  Index node[4];
  Index edges;  // 1, or 0; dropped_pair: none any more
  Index spare[3];
  double distance;   // δ⁰, m
  double thickness;  // τ, m
};

/// A pair that acts in a round of law 3; law 4 has the nodes alone, of pairs that violate.
struct alignas(16) Contact {
  Index node[4];
  double b[4];
  double mobility[4];  // b²/m, 1/kg
  Double3 normal;
  double short_of;  // γ less n·Σ b x⁰, m
  double impulse;   // λ, kg m/s
  double change;    // the missing gap of the pass, m
};

/// Nodes, triangles and edges that take part, in that order, each sort filled up to whole groups. What lies together on
/// the cloth is a cluster, and clusters are a group: boxes of neither are large, however fast another part of the cloth
/// moves.
struct CollisionItems {
  static constexpr Index width = 32;  // items of a cluster, clusters of a group
  Index count = 0, first_triangle = 0, first_edge = 0;
  Field<Index> corner;       // 3 an item: nodes, or −1
  Field<Index> rank;         // among those of its sort in the mesh
  Field<Couple> group_pair;  // all that may hold a pair
  Field<PathBox> box;        // of the items, of the clusters, of the groups
  Index clusters() const { return count / width; }
  Index groups() const { return clusters() / width; }
};

struct SelfCollisionWork {
  CollisionItems items;
  Field<std::uint8_t> member;  // per node of all cloths: takes part
  Index nodes = 0;             // that do
  double thickness = 0;        // m: the largest
  Field<Index> piece;          // per node: the least node that triangles connect it with
  // per node: for each of its triangles the two other corners, in the triangle's order
  Field<Index> around_start, around;
  // per node of all cloths
  Field<NodeVelocity> velocity;
  Field<Real3> end, seen;       // x¹, m; the same when the node's pairs were found
  Field<std::uint8_t> changed;  // its pairs are to be found again
  Field<std::int64_t> impulse;  // 3 each, units: impulse_part; 0 between passes
  Field<Index> share;           // N_k; 0 between passes
  // per node of all cloths, of law 4: meaningless before the first zone of a step
  Field<Index> zone;              // the zone's least node
  Field<Index> joined;            // 1: is in a zone (a word, for CUDA has no atomic store of less)
  Field<Index> stopped;           // at a zone's least node: 1 is to stop, 2 has stopped
  Field<Index> holder;            // at a zone's least node: the first pinned node of the zone, or no_node
  Field<std::int64_t> zone_sum;   // 4 each, at the least node: mass; momentum (units: self_collision_zones.hpp)
  Field<std::int64_t> zone_push;  // 6 each: the largest way out of bodies along +x −x +y …, d · 2^-40
  // kg, with the liquid that fits: of all cloth, for zone_sum; of its heaviest node, for impulse
  double full_mass = 0, heaviest_node = 0;
  // pairs
  double margin = 0;             // m: by how much an end may move before pairs are found again
  Field<Couple> close_clusters;  // whose boxes meet
  Field<Couple> candidate;       // items whose boxes meet
  Field<ClosePair> pair;         // that can come nearer than τ
  Index found_pairs = 0;         // in the last step, with dropped ones
  Field<Index> hole;             // places of dropped pairs
  Field<Contact> contact;
  Field<Index> counter;                                // CollisionCounter
  std::shared_ptr<struct ResidentCollision> resident;  // of CUDA (cloth/cuda/resident_collision.cpp)
};

MemoryEstimate self_collision_bytes(const Sizing& s);

}  // namespace drench::kokkos_backend
