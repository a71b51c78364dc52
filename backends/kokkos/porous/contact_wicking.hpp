#pragma once
// Liquid that passes between layers of cloth that touch: laws 4–6 of src/stages/diffusion.hpp.

#include "porous/stages.hpp"

namespace drench::kokkos_backend {

/// Which samples touch what, and how well it conducts in sub-steps of dt (s), in contact_work.
void find_contacts(const Constants& constants, const NeighborLists& lists, const Cloth& cloth, ContactWork& work,
                   double dt, bool with_momentum);
MemoryEstimate contact_wicking_bytes(const Sizing& s);
/// One sub-step; `with_momentum` changes diffusion_work.velocity.
void wick_through_contacts(const Constants& constants, Cloth& cloth, DiffusionWork& diffusion, ContactWork& work,
                           ReservoirWork& reservoirs, double dt, bool with_momentum);

}  // namespace drench::kokkos_backend
