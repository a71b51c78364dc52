#pragma once
// How dynamic bodies answer to the liquid's pressure and viscosity. Laws: docs/theory/bodies.md.
// Every function does nothing if the scene has no such body.

#include "bodies/bodies.hpp"
#include "core/reduce.hpp"
#include "coupling/wall_slip.hpp"
#include "particles/fluid.hpp"

namespace drench::kokkos_backend {

/// lists.boundary_fluid: the liquid near the samples of dynamic bodies.
void list_body_neighbors(const Constants& constants, const Fluid& fluid, Bodies& bodies, NeighborLists& lists);

/// Of this list.
MemoryEstimate body_neighbor_bytes(const Sizing& s);

/// The dynamic bodies' share of the Jacobi diagonal, added to fluid.alpha.
void add_body_rows(const Constants& constants, const NeighborLists& lists, Bodies& bodies, Fluid& fluid);

/// dynamic.force: the liquid's viscous pull at the velocities as they are.
void viscous_body_forces(const Constants& constants, Fluid& fluid, const NeighborLists& lists, Bodies& bodies,
                         const Cloth& cloth, const WallSlip& slip);
/// Adds what these forces do to the bodies at most, 1/s (bodies.hpp, law 4).
void find_viscous_body_bound(Bodies& bodies, MaximaUnderWay& maxima);

/// The velocities that the pressures κ leave the samples of bodies: dynamic.predicted = v_b + Δt (a + α × r).
void predict_bodies(const Constants& constants, const Fluid& fluid, const NeighborLists& lists,
                    const Field<Real>& kappa, double dt, Bodies& bodies);

}  // namespace drench::kokkos_backend
