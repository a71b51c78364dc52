#pragma once
// Removes slivers from a cloth's mesh: triangles so low that they are thousands of times stiffer than those around them, which
// iterative solvers pay for.

#include <string>
#include <vector>

#include "setup/surface_mesh.hpp"

namespace drench {

/// What has been done to a mesh.
struct MeshCleaning {
  std::vector<Index> node;  // of each node before
  double height = 0;        // m; triangles below it are slivers
  Index collapsed = 0;      // short edges whose ends have become one node
  Index flipped = 0;        // long edges between a sliver and its neighbour, now between their other corners
  Index dropped = 0;        // slivers along the boundary that are gone
  Index left = 0;           // slivers that stay

  bool found() const { return collapsed > 0 || flipped > 0 || dropped > 0 || left > 0; }
  /// One line about it.
  std::string text() const;
};

/// Removes triangles lower than `height` (m; clean_automatically: a hundredth of the mean edge). An edge is collapsed or flipped
/// only where the sheet keeps its topology, its boundary and its groups, and no triangle turns over. A node has the place of
/// one of those that it replaces, and the nodes keep their order.
MeshCleaning clean_mesh(SurfaceMesh& mesh, double height);

}  // namespace drench
