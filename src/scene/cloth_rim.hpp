#pragma once
// Where sheets end: what the liquid's neighbour search asks (stages/neighbors.hpp).

#include "state/model.hpp"

namespace drench {

/// Fills mesh.rim and samples.rim. A mesh's rim are the edges of one triangle alone.
void build_rim(Model& model);

}  // namespace drench
