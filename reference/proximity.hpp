#pragma once
// Nearest points of a node and a triangle, and of two edges; the pairs of cloth that may touch.

#include <array>
#include <optional>
#include <vector>

#include "common.hpp"

namespace drench::reference {

using Four = std::array<Eigen::Vector3d, 4>;

/// The nearest points of a pair: Σ b_k x_k = apart leads from the second primitive to the first.
struct Near {
  std::array<double, 4> b;
  Eigen::Vector3d apart;
};

/// Point x[0] and triangle x[1..3].
Near near_triangle(const Four& x);
/// Segments x[0] x[1] and x[2] x[3].
Near near_edges(const Four& x);
/// The first or, with `edges`, the second.
Near nearest(const Four& x, bool edges);

/// A node and a triangle without it, or two edges without a common node, of cloths with self_collision.
struct Pair {
  std::array<Index, 4> node;
  bool edges;
  double distance;   // δ⁰, m
  double thickness;  // τ, m
  double friction;   // μ

  /// γ, m: `least`, but pairs that start too near part slowly.
  double target_gap(double least) const;
};
/// All of them.
std::vector<Pair> all_pairs(const ReferenceState& state);
/// Conservative advancement from x along u, both m: how the pair stands where it first comes as near as `gap` (m); none: it
/// does not.
std::optional<Near> reaches(const Pair& pair, const Four& x, Four u, double gap);

}  // namespace drench::reference
