#pragma once
// How far the cloth's nodes stay from solids in a step (docs/theory/cloth.md, section 11).

#include "cloth/cloth.hpp"

namespace drench::kokkos_backend {

/// Sets nodes.clearance, of nodes where they begin the step and solids where they end it. Without solids nothing; one
/// stage of a step does it for all, unless solids may have changed their velocity since.
void set_clearance(const Constants& constants, const Bodies& bodies, Cloth& cloth, Real dt);

}  // namespace drench::kokkos_backend
