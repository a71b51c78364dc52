#pragma once

#include "state/model.hpp"

namespace drench {

/// Sets rest_plane and rest_center of the porous cloths (src/stages/measures.hpp), if the scene asks for measures.
void lay_rest_planes(Model& model);

}  // namespace drench
