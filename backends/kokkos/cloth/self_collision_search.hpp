#pragma once
// Which pairs of the cloth with itself can come near in a step: boxes of paths, from groups to clusters to items. Law 2
// of src/stages/self_collision.hpp then selects the pairs that do.

#include "cloth/self_collision_laws.hpp"
#include "core/gather.hpp"

namespace drench::kokkos_backend {

#ifdef KOKKOS_ENABLE_CUDA
inline constexpr Index cluster_lanes = CollisionItems::width;  // a warp has a cluster
static_assert(cluster_lanes == warp_size);
#else
inline constexpr Index cluster_lanes = 1;
#endif

namespace boxes {

/// Around the path of an item, grown by half of what may lie between two, and by what rounding may take.
template <bool all>
KOKKOS_INLINE_FUNCTION PathBox of_item(const Collision& s, Index item) {
  PathBox box;
  bool searched = all;
  for (Index k = 0; k < 3; ++k) {
    const Index n = s.corner(3 * item + k);
    if (n < 0) break;
    if (!all) searched = searched || s.changed(n) != 0;
    const Real4 from{s.position(n), 0}, to{all ? s.end(n) : s.seen(n), 0};
    box.add({from, from});
    box.add({to, to});
  }
  const Real far =
      larger(larger(larger(-box.lo.x, box.hi.x), larger(-box.lo.y, box.hi.y)), larger(-box.lo.z, box.hi.z));
  const Real grow = s.half_reach + Real(1e-6) * far;
  if (!(box.lo.x <= box.hi.x)) return {};
  return {{{box.lo.x - grow, box.lo.y - grow, box.lo.z - grow}, Real(searched ? 1 : 0)},
          {{box.hi.x + grow, box.hi.y + grow, box.hi.z + grow}, 0}};
}

#ifdef __CUDA_ARCH__
inline constexpr unsigned whole_warp = 0xffffffff;
__device__ inline PathBox around_warp(PathBox box) {
  for (int apart = warp_size / 2; apart > 0; apart /= 2) {
    PathBox o;
    o.lo = {{__shfl_xor_sync(whole_warp, box.lo.x, apart), __shfl_xor_sync(whole_warp, box.lo.y, apart),
             __shfl_xor_sync(whole_warp, box.lo.z, apart)},
            __shfl_xor_sync(whole_warp, box.lo.w, apart)};
    o.hi = {{__shfl_xor_sync(whole_warp, box.hi.x, apart), __shfl_xor_sync(whole_warp, box.hi.y, apart),
             __shfl_xor_sync(whole_warp, box.hi.z, apart)},
            0};
    box.add(o);
  }
  return box;
}
#endif

/// box(into + c): around what `make` tells of the members of cluster c. `k`: a lane's number.
template <class Make>
KOKKOS_INLINE_FUNCTION void gather_cluster(const Collision& s, Index k, Index into, const Make& make) {
#ifdef __CUDA_ARCH__
  const PathBox all = around_warp(make(k));
  if (k % warp_size == 0) s.box(into + k / warp_size) = all;
#else
  PathBox all;
  for (Index i = CollisionItems::width * k; i < CollisionItems::width * (k + 1); ++i) all.add(make(i));
  s.box(into + k) = all;
#endif
}

#ifndef __CUDA_ARCH__
/// Boxes of one cluster in arrays that vector registers can load.
struct ListedBoxes {
  static constexpr Index width = CollisionItems::width;
  Real lo[3][width] = {}, hi[3][width] = {}, searched[width] = {};
  Index meets[width] = {};

  KOKKOS_INLINE_FUNCTION void set(Index k, const PathBox& box) {
    lo[0][k] = box.lo.x, lo[1][k] = box.lo.y, lo[2][k] = box.lo.z;
    hi[0][k] = box.hi.x, hi[1][k] = box.hi.y, hi[2][k] = box.hi.z;
    searched[k] = box.lo.w;
  }
  /// PathBox::meets of all; entries that were not set have any value.
  KOKKOS_INLINE_FUNCTION void compare(const PathBox& own) {
    for (Index k = 0; k < width; ++k)
      meets[k] = ((own.lo.w > 0) | (searched[k] > 0)) & (own.lo.x <= hi[0][k]) & (lo[0][k] <= own.hi.x) &
                 (own.lo.y <= hi[1][k]) & (lo[1][k] <= own.hi.y) & (own.lo.z <= hi[2][k]) & (lo[2][k] <= own.hi.z);
  }
};
#endif

/// Lists the couples of what is in two clusters whose boxes meet; of one with itself each but once. `first`: of the
/// boxes within, `around`: of the clusters' own. `k`: a lane's number; `same`: also each with itself.
KOKKOS_INLINE_FUNCTION void compare(const Collision& s, const Couple& clusters, Index lane, Index first, Index around,
                                    bool same, CollisionCounter counter, const Entries<Couple>& list, Index room) {
  constexpr Index width = CollisionItems::width;
  const Index a = width * clusters.first, b = width * clusters.second;
  const bool one = a == b;
#ifdef __CUDA_ARCH__
  const PathBox own = s.box(first + a + lane);
  const bool mine = own.meets(s.box(around + clusters.second));
  if (!__any_sync(whole_warp, mine)) return;
  const bool theirs = s.box(first + b + lane).meets(s.box(around + clusters.first));
  unsigned found = 0;
  for (unsigned left = __ballot_sync(whole_warp, theirs); left != 0; left &= left - 1) {
    const int j = __ffs(static_cast<int>(left)) - 1;
    if (mine && (!one || lane < j || (same && lane == j)) && own.meets(s.box(first + b + j))) found |= 1u << j;
  }
  const int count = __popc(found);
  int before = count;
  for (int apart = 1; apart < warp_size; apart *= 2) {
    const int other = __shfl_up_sync(whole_warp, before, static_cast<unsigned>(apart));
    if (lane >= apart) before += other;
  }
  Index at = 0;
  if (lane == warp_size - 1 && before > 0) at = atomicAdd(&s.counter(counter), before);
  at = __shfl_sync(whole_warp, at, warp_size - 1) + before - count;
  for (; found != 0; found &= found - 1, ++at)
    if (at < room) list(at) = {a + lane, b + __ffs(static_cast<int>(found)) - 1};
#else
  (void)lane;
  // Only items that meet the other cluster's box are compared, and room in the list is taken once per item.
  const PathBox around_a = s.box(around + clusters.first), around_b = s.box(around + clusters.second);
  Index theirs[width], count = 0;
  ListedBoxes boxes;
  for (Index j = b; j < b + width; ++j) {
    const PathBox box = s.box(first + j);
    theirs[count] = j;
    boxes.set(count, box);
    count += box.meets(around_a) ? 1 : 0;
  }
  for (Index i = a; i < a + width && count > 0; ++i) {
    const PathBox own = s.box(first + i);
    if (!own.meets(around_b)) continue;
    Index hit[width], hits = 0;
    boxes.compare(own);
    for (Index k = 0; k < count; ++k) {
      const Index j = theirs[k];
      hit[hits] = j;
      hits += boxes.meets[k] != 0 && (!one || i < j || (same && i == j)) ? 1 : 0;
    }
    if (hits == 0) continue;
    const Index at = Kokkos::atomic_fetch_add(&s.counter(counter), hits);
    for (Index k = 0; k < hits && at + k < room; ++k) list(at + k) = {i, hit[k]};
  }
#endif
}

}  // namespace boxes

/// The nodes whose pairs are to be found again; they are seen anew.
struct SeeChanges {
  static constexpr const char* label = "drench::self_collision::changes";
  KOKKOS_INLINE_FUNCTION static void act(const Collision& s, Index n) {
    if (n == 0) {
      s.counter(count_pairs) = pairs(s.counter(count_pairs), s.counter(count_new), s.counter(count_holes));
      s.counter(count_new) = s.counter(count_holes) = 0;
    }
    const bool changed = s.has_moved(n);
    s.changed(n) = changed ? 1 : 0;
    if (!changed) return;
    s.seen(n) = s.end(n);
    add_one(s.counter(count_changed));
  }
  /// All, with those that are no more.
  KOKKOS_INLINE_FUNCTION static Index pairs(Index before, Index added, Index holes) {
    return added > holes ? before + (added - holes) : before;
  }
};
struct DropPair {
  static constexpr const char* label = "drench::self_collision::drop";
  KOKKOS_INLINE_FUNCTION static void act(const Collision& s, Index p) {
    const ClosePair pair = s.pair(p);
    bool drop = pair.edges == dropped_pair;
    for (int k = 0; k < 4; ++k) drop = drop || s.changed(pair.node[k]) != 0;
    if (!drop) return;
    s.pair(p).edges = dropped_pair;
    s.hole(add_one(s.counter(count_holes))) = p;
  }
};

/// Of all paths, which are seen, or of the nodes that have changed; by lanes of clusters.
template <bool all>
struct BoxItems {
  static constexpr const char* label = "drench::self_collision::boxes";
  KOKKOS_INLINE_FUNCTION static void act(const Collision& s, Index k) {
    if (k == 0) {
      s.counter(count_changed) = s.counter(count_close_clusters) = s.counter(count_candidates) = s.counter(ends_moved) =
          0;
      if (all) s.counter(count_pairs) = s.counter(count_new) = s.counter(count_holes) = 0;
    }
    boxes::gather_cluster(s, k, s.items, [&](Index item) {
      if (all && item < s.first_triangle && s.corner(3 * item) >= 0)
        s.seen(s.corner(3 * item)) = s.end(s.corner(3 * item));
      return s.box(item) = boxes::of_item<all>(s, item);
    });
  }
};
struct BoxGroups {
  static constexpr const char* label = "drench::self_collision::group_boxes";
  KOKKOS_INLINE_FUNCTION static void act(const Collision& s, Index k) {
    boxes::gather_cluster(s, k, s.items + s.clusters, [&](Index cluster) { return s.box(s.items + cluster); });
  }
};
struct CompareGroups {
  static constexpr const char* label = "drench::self_collision::close_clusters";
  KOKKOS_INLINE_FUNCTION static void act(const Collision& s, Index k) {
    boxes::compare(s, s.group_pair(k / cluster_lanes), k % cluster_lanes, s.items, s.items + s.clusters, true,
                   count_close_clusters, s.close_clusters, s.cluster_room);
  }
};
struct CompareClusters {
  static constexpr const char* label = "drench::self_collision::candidates";
  KOKKOS_INLINE_FUNCTION static void act(const Collision& s, Index k) {
    boxes::compare(s, s.close_clusters(k / cluster_lanes), k % cluster_lanes, 0, s.items, false, count_candidates,
                   s.candidate, s.candidate_room);
  }
};

/// Lists a candidate if it is a pair and can come nearer than τ, whatever ends do within the margin.
struct FindPair {
  static constexpr const char* label = "drench::self_collision::pairs";
  KOKKOS_INLINE_FUNCTION static void act(const Collision& s, Index k) {
    ClosePair pair{};
    if (!nodes_of(s, s.candidate(k), pair)) return;
    Double3 x[4], u[4];
    s.paths(pair, s.seen, x, u);
    pair.thickness = 0.5 * (double(s.materials(pair.node[0]).thickness) + double(s.materials(pair.node[3]).thickness));
    pair.distance = proximity(pair.edges != 0, x).distance;
    // Every displacement may still change by the margin: relative to the mean by 3/4 of it and 3/4 more for the other
    // three.
    if (pair.distance - relative_travel(pair.edges != 0, u) - 3.001 * s.margin > pair.thickness) return;
    const Index number = add_one(s.counter(count_new)), holes = s.counter(count_holes);
    const Index at = number < holes ? s.hole(number) : s.counter(count_pairs) + (number - holes);
    if (at < s.pair_room) s.pair(at) = pair;
  }
  /// False: they share a node, or have nodes that are sewn together.
  KOKKOS_INLINE_FUNCTION static bool nodes_of(const Collision& s, const Couple& c, ClosePair& pair) {
    const bool edges = c.first >= s.first_triangle;
    const bool turned = edges && s.rank(c.second) < s.rank(c.first);
    const Index first = 3 * (turned ? c.second : c.first), second = 3 * (turned ? c.first : c.second);
    pair.edges = edges ? 1 : 0;
    pair.node[0] = s.corner(first);
    for (Index k = 1; k < 4; ++k)
      pair.node[k] = edges ? (k == 1 ? s.corner(first + 1) : s.corner(second + k - 2)) : s.corner(second + k - 1);
    const Index own = edges ? 2 : 1;
    for (Index i = 0; i < own; ++i)
      for (Index j = own; j < 4; ++j)
        if (joint_of(s.joint, pair.node[i]) == joint_of(s.joint, pair.node[j])) return false;
    return true;
  }
};

}  // namespace drench::kokkos_backend
