#pragma once
// The start that cloths with self_collision need: no intersections, and triangles larger than their thickness.

#include "state/model.hpp"

namespace drench {

/// Throws SetupError if a cloth with self_collision is thicker than half the height of its smallest triangle (it would
/// push neighbouring triangles apart), or if an edge of such cloths passes through a triangle of them.
void refuse_self_intersections(const Model& m);

}  // namespace drench
