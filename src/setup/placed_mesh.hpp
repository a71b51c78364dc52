#pragma once
// A cloth's mesh from its file or grid to where the cloth starts.

#include <Eigen/Core>
#include <string>

#include "setup/cloth_mesh.hpp"
#include "setup/weld.hpp"

namespace drench {

/// A cloth's own mesh where it starts, and what its file's points have become.
struct PlacedMesh {
  SurfaceMesh mesh;
  Weld weld;
};

/// Reads or makes the mesh, turns and moves it, separates sheets that share an edge, sews seams and removes slivers as
/// the scene asks for. `lines` gets what was done. SetupError: a mesh that cannot be cloth.
PlacedMesh placed_mesh(const ClothScene& cloth, const std::string& scene_path, SetupLines& lines);

/// How `place` turns the cloth. SetupError: an axis without length.
Eigen::Matrix3d rotation_of(const ClothScene& cloth);

}  // namespace drench
