#pragma once
// The cloths' meshes at rest: geometry, lumped masses, springs, hinges, pins.

#include <string>
#include <vector>

#include "setup/surface_mesh.hpp"
#include "state/model.hpp"

namespace drench {

/// A rectangle in the plane y = 0, centred on the origin, node i + j·nodes[0] at column i (x) and row j (z); the
/// normals of its triangles point to +y, and the diagonals alternate from cell to cell.
SurfaceMesh grid_mesh(const GridScene& grid);

/// Cotangent vector K of a hinge (Bergou et al. 2006): x0 x1 on the shared edge, x2 x3 opposite. Σ K = 0, and Σ K_i x_i
/// = 0 for every flat hinge, stretched or not by an affine map.
std::array<double, 4> hinge_cotangents(const Vec3& x0, const Vec3& x1, const Vec3& x2, const Vec3& x3);

/// What the set-up tells, one line each.
struct SetupLines {
  std::vector<std::string> warnings;  // mistakes that a run survives
  std::vector<std::string> notes;     // what it has done to the meshes
  std::vector<std::string> hints;     // meshes whose unit is likely another one
};

/// Builds model.cloths (materials, node and triangle ranges) and model.mesh from the scene's cloths; model.scene is the
/// scene. SetupError: bad mesh, a pin or a seam that does not fit. Pins that catch nothing become warnings.
void build_cloths(const Scene& scene, Model& model, SetupLines& lines);

/// Rows of node → items from `entries` of (node, item); each row keeps the entries' order.
Rows rows_of(Index nodes, const std::vector<std::array<Index, 2>>& entries);

/// m: mean rest length of the edges of the porous cloths, or of all cloths if none is porous; 0 without cloths.
double mean_edge_length(const Model& model);

/// "cloth 'name'", for messages.
std::string cloth_label(const std::string& name);

}  // namespace drench
