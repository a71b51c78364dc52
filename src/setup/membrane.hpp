#pragma once
// What acts on the deformation of a cloth's triangles: strain limits and woven membranes (docs/theory/cloth.md, sections 2, 5).

#include <array>
#include <vector>

#include "setup/surface_mesh.hpp"
#include "state/model.hpp"

namespace drench {

/// Of each triangle the direction of `warp`, in the mesh's axes, as cosine and sine in the triangle's frame: its first axis is
/// along its first edge, the second towards its third corner. SetupError, beginning with `name`, where it is normal to one.
std::vector<std::array<double, 2>> warp_in_triangles(const SurfaceMesh& mesh, const Vec3& warp, const std::string& name);

/// Rest shapes of the triangles, limits and membranes of model.mesh, if a cloth has either. Index: cloths.
void set_triangle_stiffness(Model& model, const std::vector<std::vector<std::array<double, 2>>>& warp);

}  // namespace drench
