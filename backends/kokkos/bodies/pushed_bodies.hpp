#pragma once
// What cloth does to dynamic bodies: impulses, added up as integers, and velocities that follow
// (docs/theory/bodies.md).

#include "bodies/bodies.hpp"
#include "core/fixed_point.hpp"

namespace drench::kokkos_backend {

/// Impulses on measured bodies, as kernels add them. Empty where nothing is asked for.
struct PushesOnBodies {
  Entries<std::int64_t> sum;  // 6 per body, in `unit`: impulse, kg m/s; about the centre, kg m²/s
  Entries<const RigidBody> constant;
  double unit = 1;

  PushesOnBodies() = default;
  PushesOnBodies(const Constants& constants, Bodies& bodies)
      : sum(bodies.dynamic.pushed), constant(bodies.constant), unit(constants.quantum / impulse_steps) {}

  KOKKOS_INLINE_FUNCTION bool takes(std::size_t b) const { return sum.exist() && constant(Index(b)).measured != 0; }
  KOKKOS_INLINE_FUNCTION bool takes_commanded(std::size_t b) const {
    return takes(b) && constant(Index(b)).dynamic == 0;
  }
  /// The impulse p (kg m/s) at `arm` (m) from the centre of body b.
  KOKKOS_INLINE_FUNCTION void add(std::size_t b, const Double3& arm, const Double3& p) const {
    const Double3 turn = outer(arm, p);
    const double part[6] = {p.x, p.y, p.z, turn.x, turn.y, turn.z};
    for (int a = 0; a < 6; ++a) Kokkos::atomic_add(&sum(6 * Index(b) + a), fixed_point(part[a] / unit));
  }
};

/// No pushes yet. Makes the array.
void clear_pushes(Bodies& bodies);
/// Impulses that have been added: force and torque times time. Waits.
std::vector<Wrench> pushes_on(const Constants& constants, const Bodies& bodies);
/// The state with the velocities after an impulse; a body that is not dynamic keeps its own.
RigidState pushed(const RigidBody& body, const RigidState& state, const Wrench& impulse);
/// The bodies move so; samples with them.
void set_states(Bodies& bodies, const std::vector<RigidState>& states);

}  // namespace drench::kokkos_backend
