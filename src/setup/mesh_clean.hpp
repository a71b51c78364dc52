#pragma once
// Removes slivers from a cloth's mesh: triangles of small height are thousands of times stiffer than their neighbours,
// so iterative solvers converge slowly.

#include <string>
#include <vector>

#include "setup/surface_mesh.hpp"

namespace drench {

/// What has been done to a mesh.
struct MeshCleaning {
  std::vector<Index> node;  // of each node before
  std::vector<Index> kept;  // of each node now, the one before whose place it has
  double height = 0;        // m; triangles of a smaller height are slivers
  Index collapsed = 0;      // short edges whose ends have become one node
  Index flipped = 0;        // long edges between a sliver and its neighbour, now between their other corners
  Index dropped = 0;        // slivers along the boundary that were removed
  Index left = 0;           // slivers that could not be removed

  bool found() const { return collapsed > 0 || flipped > 0 || dropped > 0 || left > 0; }
  /// One line about it.
  std::string text() const;
};

/// Removes triangles whose height is below `height` (m; clean_automatically: a hundredth of the mean edge length). An
/// edge is collapsed or flipped only if topology, boundary and groups of the mesh stay the same and no triangle is
/// inverted. A merged node keeps the position of one of its nodes, and the order of the nodes does not change.
MeshCleaning clean_mesh(SurfaceMesh& mesh, double height);

}  // namespace drench
