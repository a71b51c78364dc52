#pragma once
// The order of stage self_collision's laws, once its pairs are found: on the device in one kernel, or a kernel a law.

#include "cloth/self_collision_search.hpp"
#include "cloth/self_collision_zones.hpp"

namespace drench::kokkos_backend {

/// How far the stage has come.
struct CollisionProgress {
  static constexpr int rounds = 3, passes = 8;

  bool begun = false, found = false, zones = false, done = false;  // not done: there was no room for what was found
  int next_round = 0;                                              // of law 3
  int searches = 0, zone_moves = 0;
  Index close_clusters = 0, candidates = 0, pairs = 0;
  Index contacts = 0;  // of the first round
  Index zone_nodes = 0;
};

// A `Grid` runs `each<Law>(s, n)`, which ends when Law::act(s, i) has for all i < n, and tells `value(s, counter)`.
#ifdef __NVCC__
#pragma nv_exec_check_disable
#endif
template <class Grid>
KOKKOS_INLINE_FUNCTION void push_apart(const Grid& grid, const Collision& s, Index contacts) {
  for (int pass = 0; pass < CollisionProgress::passes; ++pass) {
    grid.template each<FindGap>(s, contacts);
    grid.template each<Push>(s, contacts);
    grid.template each<ApplyImpulses>(s, s.nodes);
  }
  grid.template each<CountPressed>(s, contacts);
  grid.template each<ApplyFriction>(s, contacts);
  grid.template each<EndRound>(s, s.nodes);
}

/// Finds the pairs of the paths as they are, or those of nodes that have changed. False: there is no room.
#ifdef __NVCC__
#pragma nv_exec_check_disable
#endif
template <bool all, class Grid>
KOKKOS_INLINE_FUNCTION bool find_pairs(const Grid& grid, const Collision& s, CollisionProgress& at) {
  constexpr Index a_lane = CollisionItems::width / cluster_lanes;  // items that a lane has
  ++at.searches;
  at.found = false;
  grid.template each<BoxItems<all>>(s, s.items / a_lane);
  grid.template each<BoxGroups>(s, s.clusters / a_lane);
  grid.template each<CompareGroups>(s, s.group_pairs * cluster_lanes);
  at.close_clusters = grid.value(s, count_close_clusters);
  if (at.close_clusters > s.cluster_room) return false;
  grid.template each<CompareClusters>(s, at.close_clusters * cluster_lanes);
  at.candidates = grid.value(s, count_candidates);
  if (at.candidates > s.candidate_room) return false;
  grid.template each<FindPair>(s, at.candidates);
  at.pairs = SeeChanges::pairs(all ? 0 : at.pairs, grid.value(s, count_new), grid.value(s, count_holes));
  at.found = at.pairs <= s.pair_room;
  return at.found;
}
/// The same if those that there are are not all; if few nodes have changed, theirs alone.
#ifdef __NVCC__
#pragma nv_exec_check_disable
#endif
template <class Grid>
KOKKOS_INLINE_FUNCTION bool renew_pairs(const Grid& grid, const Collision& s, CollisionProgress& at) {
  constexpr Index few = 4;  // at most one in so many
  if (!at.found) return find_pairs<true>(grid, s, at);
  if (grid.value(s, ends_moved) == 0) return true;
  grid.template each<SeeChanges>(s, s.nodes);
  if (few * grid.value(s, count_changed) > s.nodes) return find_pairs<true>(grid, s, at);
  grid.template each<DropPair>(s, at.pairs);
  return find_pairs<false>(grid, s, at);
}

/// Law 4. False: there is no room.
#ifdef __NVCC__
#pragma nv_exec_check_disable
#endif
template <class Grid>
KOKKOS_INLINE_FUNCTION bool join_zones(const Grid& grid, const Collision& s, CollisionProgress& at) {
  while (true) {
    if (!renew_pairs(grid, s, at)) return false;
    if (at.zones)
      grid.template each<FindViolation>(s, at.pairs);
    else
      grid.template each<FindFirstViolation>(s, at.pairs);
    const Index violations = at.pairs > 0 ? grid.value(s, count_contacts) : 0;
    if (violations == 0) return true;
    if (!at.zones) grid.template each<BeginZones>(s, s.nodes);
    at.zones = true;
    ++at.zone_moves;
    grid.template each<JoinZones>(s, violations);
    grid.template each<NameZones>(s, s.nodes);
    grid.template each<SumZones>(s, s.nodes);
    if (s.solids.count > 0) grid.template each<PushZones>(s, s.nodes);
    grid.template each<MoveZones>(s, s.nodes);
  }
}

/// Goes on until the stage is done, or until there is no room.
#ifdef __NVCC__
#pragma nv_exec_check_disable
#endif
template <class Grid>
KOKKOS_INLINE_FUNCTION CollisionProgress keep_apart(const Grid& grid, const Collision& s, CollisionProgress at) {
  if (!at.begun) grid.template each<Begin>(s, s.nodes);
  at.begun = true;
  while (CollisionProgress::rounds > at.next_round) {
    if (!renew_pairs(grid, s, at)) return at;
    if (at.pairs == 0) break;
    if (at.next_round == 0) grid.template each<VoteOnSides>(s, at.pairs);
    grid.template each<FindContact>(s, at.pairs);
    const Index contacts = grid.value(s, count_contacts);
    if (contacts == 0) break;
    if (at.next_round == 0) at.contacts = contacts;
    push_apart(grid, s, contacts);
    ++at.next_round;
  }
  at.next_round = CollisionProgress::rounds;
  if (at.contacts > 0 && !join_zones(grid, s, at)) return at;
  if (at.zones) grid.template each<CountZoneNodes>(s, s.nodes);
  grid.template each<Finish>(s, s.nodes);
  if (at.zones) at.zone_nodes = grid.value(s, count_zone_nodes);
  at.done = true;
  return at;
}

/// A kernel a law; the host waits for every number.
struct Launches {
  template <class Law>
  struct Task {
    Collision s;
    KOKKOS_INLINE_FUNCTION void operator()(const Index i) const { Law::act(s, i); }
  };
  template <class Law>
  void each(const Collision& s, Index n) const {
    parallel(Law::label, n, Task<Law>{s});
  }
  Index value(const Collision& s, CollisionCounter which) const;
};

// cuda/resident_collision.cpp: all in one kernel that stays on the device.
/// Can it be done: on CUDA, with cooperative launches? (Then it makes what it needs.)
bool prepare_resident_collision(SelfCollisionWork& work);
CollisionProgress keep_apart_resident(SelfCollisionWork& work, const Collision& s, const CollisionProgress& at);

}  // namespace drench::kokkos_backend
