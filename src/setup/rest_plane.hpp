#pragma once

#include "state/model.hpp"

namespace drench {

/// Sets rest_plane and rest_center of the porous cloths, for the stages measures and fabric. With fabric the first axis is the
/// warp, where the cloth knows it: the mean of its triangles', or a grid's z.
void lay_rest_planes(Model& model);

}  // namespace drench
