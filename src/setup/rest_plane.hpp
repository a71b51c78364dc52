#pragma once

#include <vector>

#include "state/model.hpp"

namespace drench {

/// Sets rest_plane and rest_center of the porous cloths, for the stages measures and fabric. With fabric the first axis
/// is the warp, where the cloth knows it: the mean of its triangles', or a grid's z.
void lay_rest_planes(Model& model);

/// Where each node lies in its cloth's plane at rest, from the centre: 2 per node, m.
std::vector<double> places_in_rest_planes(const Model& model);

}  // namespace drench
