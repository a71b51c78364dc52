#pragma once
// The order of stage self_collision's laws, once its pairs are found: on the device in one kernel, or a kernel a law.

#include "cloth/self_collision_zones.hpp"

namespace drench::kokkos_backend {

/// How far the stage has come.
struct CollisionProgress {
  static constexpr int rounds = 3, passes = 8;
  enum Stop : int { done, ends_moved_on, no_room };  // the pairs are to be found again; there was no room for them

  Index pairs = 0;
  int round = 0;      // of law 3, the next
  bool zones = false;
  Stop stop = done;
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

/// Law 4. False: ends have moved on.
#ifdef __NVCC__
#pragma nv_exec_check_disable
#endif
template <class Grid>
KOKKOS_INLINE_FUNCTION bool join_zones(const Grid& grid, const Collision& s, CollisionProgress& at) {
  while (true) {
    if (at.zones)
      grid.template each<FindViolation>(s, at.pairs);
    else
      grid.template each<FindFirstViolation>(s, at.pairs);
    const Index violations = grid.value(s, count_contacts);
    if (violations == 0) return true;
    if (!at.zones) grid.template each<BeginZones>(s, s.nodes);
    at.zones = true;
    grid.template each<JoinZones>(s, violations);
    grid.template each<NameZones>(s, s.nodes);
    grid.template each<SumZones>(s, s.nodes);
    if (s.solids.count > 0) grid.template each<PushZones>(s, s.nodes);
    grid.template each<MoveZones>(s, s.nodes);
    if (grid.value(s, ends_moved) != 0) return false;
  }
}

/// Goes on until the stage is done, or until pairs must be found again.
#ifdef __NVCC__
#pragma nv_exec_check_disable
#endif
template <class Grid>
KOKKOS_INLINE_FUNCTION CollisionProgress keep_apart(const Grid& grid, const Collision& s, CollisionProgress at) {
  at.pairs = grid.value(s, count_pairs);
  at.stop = CollisionProgress::no_room;
  if (at.pairs > s.capacity) return at;
  at.stop = CollisionProgress::ends_moved_on;
  while (at.round < CollisionProgress::rounds) {
    if (at.pairs > 0) grid.template each<FindContact>(s, at.pairs);
    const Index contacts = at.pairs > 0 ? grid.value(s, count_contacts) : 0;
    if (contacts == 0) break;
    if (at.round == 0) at.contacts = contacts;
    push_apart(grid, s, contacts);
    ++at.round;
    if (grid.value(s, ends_moved) != 0) return at;
  }
  at.round = CollisionProgress::rounds;
  if (at.contacts > 0 && !join_zones(grid, s, at)) return at;
  if (at.zones) grid.template each<CountZoneNodes>(s, s.nodes);
  grid.template each<Finish>(s, s.nodes);
  if (at.zones) at.zone_nodes = grid.value(s, count_zone_nodes);
  at.stop = CollisionProgress::done;
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
