#pragma once
// Makes a cloth's mesh a manifold: where more than two triangles share an edge, the sheets are separated.

#include <array>
#include <string>
#include <vector>

#include "setup/surface_mesh.hpp"

namespace drench {

/// What has been done to a mesh.
struct SheetSplit {
  Index repeated = 0;                      // triangles with the same three points as an earlier one, which are omitted
  std::array<Index, 3> first_repeated{};   // points of the first of them
  Index edges = 0;                         // with more than two triangles
  std::vector<Index> copy_of;              // of each point that was appended, the one whose place it has
  std::vector<std::array<Index, 2>> held;  // pairs of points that were one, sorted

  bool found() const { return repeated > 0 || edges > 0; }
  /// One line about it.
  std::string text() const;
};

/// Omits repeated triangles, whatever their orientation. At an edge with more than two triangles, the two that bend
/// least against each other stay joined, of the others again two, and so on; points are copied so that the sheets share
/// none at that edge. Texture and groups follow.
SheetSplit split_sheets(SurfaceMesh& mesh);

}  // namespace drench
