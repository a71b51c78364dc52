#pragma once
// The solid that a body's mesh bounds, also where the mesh has holes, branches, or triangles turned the wrong way.

#include <vector>

#include "setup/surface_mesh.hpp"

namespace drench {

struct MeshHole {
  Vec3 center{0, 0, 0};  // m: of its bounding box
  double width = 0;      // m: the longest side of that
};

/// A mesh that is turned outwards and along whose edges as many triangles go as go back: two, but in edges where a wall
/// within the solid meets its surface. So its winding number is a whole number everywhere but on the surface.
struct SolidMesh {
  std::vector<Index> source;                    // of each point: which of the given ones it is
  std::vector<std::array<Index, 3>> triangles;  // the given ones in their order, then those that cover holes
  std::vector<MeshHole> holes;                  // the largest first; those without area are covered and not listed
  double cover_share = 0;                       // area of all covers over that of the mesh
  double volume = 0, area = 0;                  // m³, m²: with the covers
  std::size_t branches = 0;                     // edges on which more than two triangles of one piece meet
  Vec3 branch{0, 0, 0};                         // m: on the first of them
  std::size_t left_out = 0;                     // triangles of sheets
  Index joined = 0;                             // points and edges of patches that enclose a volume only together, ...
  double gap = 0;                               // ... and the widest gap between them, m
  /// Has it an inside? A sheet has none: what covers its edge is as large as it is.
  bool has_inside() const;
};

/// What becomes of pieces that have no inside, beside others that have one.
enum class Sheets { keep, leave_out };

/// Patches that enclose a volume only together are joined across narrow gaps (setup/close_gaps.hpp). Steps then: points
/// at the same place, to rounding, become one where triangles of both have no other neighbour there, so seams close and
/// pieces that only touch stay apart; neighbours are turned alike; the holes of each piece are covered; each piece is
/// turned outwards by its volume; where more than two triangles meet in an edge, those are neighbours that enclose
/// solid between them. `mesh` has finite points, and no triangle of it names one twice.
SolidMesh close_mesh(const SurfaceMesh& mesh, Sheets sheets = Sheets::keep);

/// Do as many triangles go along each edge as go back? Then the mesh has an inside and an outside.
bool bounds_solid(const std::vector<std::array<Index, 3>>& triangles);

}  // namespace drench
