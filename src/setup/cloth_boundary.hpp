#pragma once
// The boundary edges of the cloths, where sheets end: for the liquid's neighbour search (stages/neighbors.hpp).

#include "state/model.hpp"

namespace drench {

/// Fills mesh.boundary_edge, the edges of one triangle alone, and samples.boundary_edges, those near each sample.
void find_boundary_edges(Model& model);

}  // namespace drench
