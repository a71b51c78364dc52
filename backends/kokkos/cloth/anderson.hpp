#pragma once
// Anderson acceleration of the cloth's Newton steps on a host (docs/theory/cloth.md, section 8).

#include <vector>

#include "cloth/node_vectors.hpp"

namespace drench::kokkos_backend {

class AndersonAcceleration {
 public:
  explicit AndersonAcceleration(Index nodes) : nodes_(nodes) {}
  /// Forgets all iterates.
  void clear();
  /// `step` (m) from the iterate `shift` (m), where the forces `left` (N) are unbalanced, becomes the combination with
  /// the last steps that leaves the least. False: there is nothing to combine, and the step stays as it is.
  bool combine(const std::vector<Double3>& shift, const NodeVector& left, NodeVector& step);

 private:
  static constexpr std::size_t most_kept = 8;

  void keep_differences(const std::vector<Double3>& shift, const NodeVector& left, const NodeVector& step);

  Index nodes_;
  bool has_last_ = false;
  std::vector<Double3> last_shift_;
  NodeVector last_left_, last_step_;
  std::vector<NodeVector> along_, step_change_, left_change_;  // Δu + Δz and Δz, m; Δr, N
  ChunkedSums sums_;
};

}  // namespace drench::kokkos_backend
