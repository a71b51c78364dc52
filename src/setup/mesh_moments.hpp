#pragma once
// Volume, centre and second moments of the solid within a closed mesh.

#include <Eigen/Core>
#include <array>
#include <vector>

#include "base/types.hpp"

namespace drench {

struct MeshMoments {
  double volume = 0;  // m³
  Eigen::Vector3d center = Eigen::Vector3d::Zero();
  Eigen::Matrix3d second = Eigen::Matrix3d::Zero();  // ∫ x xᵀ dV about the centre, m⁵
};

/// Of what is inside: where the mesh goes at least once around. Sums over the triangles count places too often where
/// parts of the mesh overlap; these are found along a lattice of lines. So the result is exact without overlaps, and
/// where what overlaps are boxes along the axes; else the volume is exact to about 1e-4. Nearest to `origin`, m, the
/// sums lose least by rounding.
MeshMoments moments_of(const std::vector<Vec3>& points, const std::vector<std::array<Index, 3>>& triangles,
                       const Vec3& origin);

}  // namespace drench
