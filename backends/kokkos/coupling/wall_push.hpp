#pragma once
// What dynamic bodies lose to the pressure that is extrapolated along their surface (docs/theory/walls_and_sheets.md,
// Eqs. 7e and 7f).
//
// Reads:  fluid.wall_gain, the lists of the step, positions (m), volumes (m³).
// Writes: the bodies' velocities (m/s, rad/s) and boundary.velocity of their samples.
// Errors: none. Only where walls extrapolate and a body is dynamic; elsewhere nothing is allocated or launched.

#include "bodies/bodies.hpp"
#include "particles/fluid.hpp"

namespace drench::kokkos_backend {

/// Whether a stage that multiplies changes of velocity with L_i owes dynamic bodies the reaction.
inline bool has_wall_push(const Constants& constants, const Bodies& bodies) {
  return constants.model.extrapolates_walls() && bodies.dynamic.count > 0;
}

/// fluid.wall_gain.push, for the stage to fill with its change of each particle's velocity, m/s.
Entries<Real3> room_for_wall_push(Fluid& fluid);

/// The bodies lose what the walls have given of fluid.wall_gain.push. Angular momentum is exact too: it acts at the
/// particles.
void push_bodies_back(const Constants& constants, const NeighborLists& lists, Fluid& fluid, Bodies& bodies);
/// The same at the start of a solve, which `ahead` keeps, kg m/s and kg m²/s.
void push_bodies_ahead(const Constants& constants, const NeighborLists& lists, Fluid& fluid, Bodies& bodies,
                       Field<Wrench>& ahead);
/// The same at its end: what they lose beyond `ahead`.
void push_bodies_further(const Constants& constants, const NeighborLists& lists, Fluid& fluid, Bodies& bodies,
                         const Field<Wrench>& ahead);

/// A particle's, of fluid.wall_gain.push.
double wall_push_bytes(const Sizing& s);

}  // namespace drench::kokkos_backend
