#pragma once
// Nearest points of a node and a triangle, and of two edges.

#include <Eigen/Core>
#include <array>

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

}  // namespace drench::reference
