#pragma once
// Seams of a mesh file whose points are doubled: boundary points that coincide become one node.

#include <array>
#include <string>
#include <vector>

#include "setup/surface_mesh.hpp"

namespace drench {

/// What the mesh file's points have become.
struct Weld {
  std::vector<Index> node;                 // of each point of the file, and then of each copy
  std::vector<Index> copy_of;              // the file's point of each copy (setup/sheets.hpp)
  std::vector<Index> place_of;             // of each node, the file's point whose place it has
  Index merged = 0;                        // pairs of points that have become one node
  std::vector<std::array<Index, 2>> held;  // pairs of nodes that lie together and would make an edge of three triangles
  Index layers = 0;                        // pairs left alone for their sheets lie on each other
  Index refused = 0;                       // pairs left alone for a triangle would lose its area or an edge its length
  Index open = 0;     // pairs beyond reach, but nearer than a tenth of their edges, and at most ...
  double widest = 0;  // ... so far apart, m

  std::size_t file_points() const { return node.size() - copy_of.size(); }
  bool found() const { return merged > 0 || !held.empty() || layers > 0 || refused > 0 || open > 0; }
  /// One line about it.
  std::string text() const;
};

/// Merges boundary points of `mesh` that are at most `distance` (m) apart; weld_automatically: a thousandth of the
/// shortest edges at the two points. Never two of one triangle. Sheets that lie on each other are left alone unless
/// there is a distance. A node has the place of its first point, and the nodes keep the order of these; texture and
/// groups stay as they are. `copy_of`: of the last points the ones that they are copies of; these are left apart.
Weld weld_boundary(SurfaceMesh& mesh, double distance, const std::vector<Index>& copy_of = {});

}  // namespace drench
