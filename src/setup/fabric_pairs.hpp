#pragma once
// Which nodes pass liquid on to which within the fabric, and how well: the geometry of stage diffusion.

#include "state/model.hpp"

namespace drench {

/// Fills model.fabric for the porous cloths with a diffusivity, from their rest shape (stages/diffusion.hpp, law 1).
void build_fabric_pairs(Model& model);

}  // namespace drench
