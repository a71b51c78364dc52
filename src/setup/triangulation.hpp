#pragma once
// Polygons divided into triangles.

#include <array>
#include <vector>

#include "base/types.hpp"

namespace drench {

/// Divides a polygon of n corners (m) into n − 2 triangles of its corners, whether it is convex, concave, not plane,
/// crosses itself or has corners in a line: ear clipping in the plane of its mean normal, the ear with the least
/// perimeter²/area first. The triangles are turned as the polygon is, where it does not cross itself. Some may have no
/// area, where corners coincide or all lie in a line. n < 3: none.
std::vector<std::array<int, 3>> triangulate(const std::vector<Vec3>& corners);

}  // namespace drench
