#pragma once
// Bending of a cloth by hinges, and of a grid by differences along its lines (docs/theory/cloth.md, section 3).

#include "setup/cloth_regions.hpp"

namespace drench {

/// c_h of a hinge, N/m, such that `bend` (N·m) is the flexural rigidity: a sheet rolled to curvature κ takes ½ bend κ²
/// per area. The factor 3 of Bergou et al. 2006 is left out: it is right on a sphere and three times too much on a
/// cylinder (docs/dev/cloth.md, "Bending"). Between two fabrics both triangles carry the same moment. `around`: A0 +
/// A1.
double hinge_stiffness(const Patchwork& fabric, const MeshEdge& e, const std::vector<double>& area, double around);

/// Bending of a rectangular grid: the thin plate ½ bend (z_xx² + z_zz² + 2 z_xz²) by second differences along the lines
/// at every node, and the twist of every cell. Hinges of the triangles are a fifth too soft there: their alternating
/// diagonals bend each line at every second node only.
void add_grid_bending(ClothMesh& mesh, const GridScene& grid, const Patchwork& fabric, Index first);

}  // namespace drench
