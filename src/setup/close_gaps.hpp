#pragma once
// Patches of a body's mesh that meet without common points: closes narrow gaps and T-junctions between them.

#include <array>
#include <vector>

#include "setup/surface_mesh.hpp"

namespace drench {

/// Triangles of the given points, and the places of these: points of one place are one.
struct ClosedGaps {
  std::vector<std::array<Index, 3>> triangles;
  std::vector<Index> place;  // of each point: the first one at its place
  Index joined = 0;          // points that have become one with others, and cuts of triangles at points on their edges
  double widest = 0;         // m: of the gaps
};

/// Boundary points that differ by the rounding of single precision become one.
ClosedGaps close_rounding(const SurfaceMesh& mesh);

/// Boundary points nearer to each other than a tenth of their shortest edges become one; triangles are cut where such
/// points lie as near to their boundary edges.
ClosedGaps close_gaps(const SurfaceMesh& mesh);

}  // namespace drench
