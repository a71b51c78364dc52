#pragma once
// How far the cloth's nodes stay from solids in a step (docs/theory/cloth.md, section 11).

#include "cloth/cloth.hpp"

namespace drench::kokkos_backend {

/// Sets nodes.clearance, of nodes where they begin the step and solids where they end it. Without solids nothing.
/// The first stage of a step that needs them sets them for all; with dynamic bodies, which may have been pushed since,
/// each stage does.
void set_clearance(const Constants& constants, const Bodies& bodies, Cloth& cloth, Real dt);

}  // namespace drench::kokkos_backend
