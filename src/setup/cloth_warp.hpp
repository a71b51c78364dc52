#pragma once
// Which way the warp of a fabric runs at rest, for cloth that knows its yarns: it conducts along or is as stiff as
// them.

#include <Eigen/Core>

#include "setup/cloth_regions.hpp"

namespace drench {

/// Does a cloth know warp from weft: a membrane, a plate that bends differently, or two rates of wicking?
bool needs_warp(const ClothScene& cloth);
/// Is its direction that of the mesh file's texture coordinates, where no region has its own?
bool takes_warp_of_file(const ClothScene& cloth);

/// Do the texture coordinates of a mesh give every triangle a warp?
bool texture_gives_warp(const SurfaceMesh& mesh);
/// Does a triangle of the mesh lie across this direction, so that it would have no warp there?
bool lies_across(const SurfaceMesh& mesh, const Vec3& direction);

/// Appends a unit vector for each triangle of `own`, the last mesh that was appended, placed by `rotation`. SetupError:
/// the file has no texture coordinates, a triangle has no area in them, or it lies across the direction of `warp`.
void append_warp(ClothMesh& mesh, const SurfaceMesh& own, const ClothScene& cloth, const Patchwork& fabric,
                 const Eigen::Matrix3d& rotation);

}  // namespace drench
