#pragma once
// The boundary of a triangle mesh as chains of nodes.

#include <vector>

#include "setup/surface_mesh.hpp"

namespace drench {

struct Chain {
  std::vector<Index> nodes;  // in order
  bool closed = false;       // the last is joined to the first
};

/// Chains of these edges, each edge in one of them; they begin at their lowest node and are ordered by it.
std::vector<Chain> chains_of(const std::vector<std::array<Index, 2>>& edges);

/// Chains of the edges that have one triangle.
std::vector<Chain> boundary_loops(const std::vector<std::array<Index, 3>>& triangles);

/// m
double length_of(const Chain& chain, const std::vector<Vec3>& points);

}  // namespace drench
