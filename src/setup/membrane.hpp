#pragma once
// What acts on the deformation of a cloth's triangles: strain limits and woven membranes (docs/theory/cloth.md,
// sections 2, 5).

#include <array>
#include <vector>

#include "setup/surface_mesh.hpp"
#include "state/model.hpp"

namespace drench {

/// w of strain limiting over the stiffness: once its yarns are straight, woven fabric is some ten to fifty times
/// stiffer than at the start of its curve (src/stages/cloth.hpp).
inline constexpr double straight_yarns = 20;

/// Of each triangle of `own`, the last mesh that was appended, the warp as cosine and sine in the triangle's frame: its
/// first axis is along its first edge, the second towards its third corner.
std::vector<std::array<double, 2>> warp_in_triangles(const ClothMesh& mesh, const SurfaceMesh& own);

/// Rest shapes of the triangles, limits and membranes of model.mesh, if a cloth has either. Index: cloths.
void set_triangle_stiffness(Model& model, const std::vector<std::vector<std::array<double, 2>>>& warp);

}  // namespace drench
