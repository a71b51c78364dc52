#pragma once
// The stages of porous cloth: what each reads and writes. Laws: docs/theory/porous.md.

#include "cloth/cloth.hpp"
#include "particles/fluid.hpp"
#include "porous/porous_work.hpp"
#include "state/host_state.hpp"

namespace drench::kokkos_backend {

/// Lists of samples near liquid, samples and solids, where everything is after advection.
void porous_neighbors(const Constants& constants, const Fluid& fluid, NeighborLists& lists, Bodies& bodies,
                      Cloth& cloth, DiffusionWork& diffusion);
MemoryEstimate porous_neighbor_bytes(const Sizing& s);
/// samples.flow_direction.
void flow_direction(const Constants& constants, const NeighborLists& lists, const Bodies& bodies, Cloth& cloth);
/// samples.flux, what of it passes, and the direction that pressure gives the flow.
void permeation(const Constants& constants, const Fluid& fluid, const NeighborLists& lists, const Bodies& bodies,
                Cloth& cloth, PermeationWork& work, const StepInfo& info);
MemoryEstimate permeation_bytes(const Sizing& s);
/// Liquid goes from nodes into the air.
void drying(const Constants& constants, const Fluid& fluid, const NeighborLists& lists, const Bodies& bodies,
            Cloth& cloth, DryingWork& work, Accounts& accounts, const StepInfo& info);
MemoryEstimate drying_bytes(const Sizing& s);
/// Liquid goes from particles to nodes.
void absorption(const Constants& constants, Fluid& fluid, const NeighborLists& lists, Cloth& cloth,
                TransferWork& transfers, const PermeationWork& permeation, AbsorptionWork& work, const StepInfo& info);
MemoryEstimate absorption_bytes(const Sizing& s);
/// Liquid goes from nodes to particles, other layers and new particles.
void emission(const Constants& constants, Fluid& fluid, const NeighborLists& lists, const Bodies& bodies, Cloth& cloth,
              TransferWork& transfers, EmissionWork& work, const StepInfo& info);
MemoryEstimate emission_bytes(const Sizing& s);
/// Liquid goes from node to node; reservoirs hold theirs in between.
void diffusion(const Constants& constants, const NeighborLists& lists, Cloth& cloth, DiffusionWork& work,
               ContactWork& contacts, ReservoirWork& reservoirs, Accounts& accounts, const StepInfo& info,
               StepReport& report);
MemoryEstimate diffusion_bytes(const Sizing& s);
void reservoir(const Constants& constants, Cloth& cloth, ReservoirWork& work, Accounts& accounts);
/// The nodes of reservoirs take all inflow: φ^in = 1 (docs/theory/porous.md, Limiters).
void open_reservoirs(const Constants& constants, ReservoirWork& work, Field<double>& in_share);

}  // namespace drench::kokkos_backend
