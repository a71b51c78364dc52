#pragma once
// Bending of a cloth as a thin plate on any triangle mesh (docs/theory/cloth.md, section 3).

#include <functional>
#include <vector>

#include "scene/scene.hpp"
#include "setup/surface_mesh.hpp"

namespace drench {

/// B_nm of two nodes n < m, N/m: the energy is −½ Σ B_nm |x_n − x_m|² over the pairs.
struct PlatePair {
  Index first, second;
  double weight;
};

/// In the order of their nodes; `warp`: of each triangle the warp's direction in its frame (setup/membrane.hpp), a unit
/// vector. `plate`: rigidities of each triangle.
std::vector<PlatePair> plate_pairs(const SurfaceMesh& mesh, const std::vector<MeshEdge>& edges,
                                   const std::function<PlateScene(Index)>& plate,
                                   const std::vector<std::array<double, 2>>& warp);

}  // namespace drench
