#pragma once
// Which triangles of a mesh continue each other across an edge, and which points follow from that.

#include <array>
#include <cstdint>
#include <vector>

#include "base/types.hpp"

namespace drench {

/// Of each point the first one at exactly the same place.
std::vector<Index> first_copies(const std::vector<Vec3>& points);

/// How many half-edges there are. Half-edge 3 t + c goes from corner c of triangle t to the next one.
struct HalfEdges {
  const std::vector<std::array<Index, 3>>& triangles;
  std::size_t count() const { return 3 * triangles.size(); }
  Index from(std::size_t h) const { return triangles[h / 3][h % 3]; }
  Index to(std::size_t h) const { return triangles[h / 3][(h + 1) % 3]; }
  Index opposite(std::size_t h) const { return triangles[h / 3][(h + 2) % 3]; }
};

/// Half-edges with the same two ends (by `place`, as first_copies gives them), each edge once, in a fixed order.
std::vector<std::vector<Index>> edges_by_place(const HalfEdges& sides, const std::vector<Index>& place);

enum class Branches { leave, pair };

/// Of each half-edge the one on the other side; −1: none. Two triangles that share both points of an edge, and with no
/// third, go together; of the others those that are two at their place. Where more meet, Branches::pair joins those
/// that enclose the solid between them, by the angle about the edge, if triangles are turned outwards; Branches::leave
/// joins none.
std::vector<Index> partners(const std::vector<Vec3>& points, const std::vector<std::array<Index, 3>>& triangles,
                            const std::vector<Index>& place, Branches branches);

/// Points for triangles that are joined at their half-edges and nowhere else. `source`: of each the first of the old
/// points that it stands for; they keep the old order.
struct JoinedMesh {
  std::vector<Index> source;
  std::vector<std::array<Index, 3>> triangles;
};
JoinedMesh join(const std::vector<std::array<Index, 3>>& triangles, const std::vector<Index>& place,
                const std::vector<Index>& partner);

}  // namespace drench
