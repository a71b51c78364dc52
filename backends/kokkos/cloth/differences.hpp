#pragma once
// Anderson's acceleration on a host (docs/theory/cloth.md, section 8): the last differences of iterates, residuals and steps.

#include <array>
#include <vector>

#include "core/types.hpp"

namespace drench::kokkos_backend {

class Differences {
 public:
  explicit Differences(Index nodes);
  /// Forgets all.
  void clear();
  /// The next iterate is of another target: its residual makes no difference with the last one.
  void part() { has_last_ = false; }
  bool has_last() const { return has_last_; }
  /// The iterate that the last step began at.
  void copy_last(Field<Real3>& shift) const;
  /// x := x + z − Σ γ_k (Δx_k + Δz_k) with the γ that leave the least of z in the norm of the preconditioner; r, z of x.
  void step(Field<Real3>& shift, const Field<Real3>& residual, const Field<Real3>& descent);

 private:
  static constexpr int most_kept = 20;
  using Numbers = std::vector<Real>;  // 3 a node, then 0 up to a multiple of 16

  void keep();
  int weights(Real* weight) const;
  int slot_of(int age) const { return (next_ - 1 - age + most_kept) % most_kept; }

  Numbers shift_, residual_, descent_, last_shift_, last_residual_, last_descent_;
  std::array<Numbers, most_kept> step_change_, residual_change_;  // Δx + Δz, m; Δr, N
  double product_[most_kept][most_kept] = {};                     // ⟨Δz_i, Δr_j⟩, J
  double along_[most_kept] = {};                                  // ⟨z, Δr_j⟩, J
  int kept_ = 0, next_ = 0;                                       // differences, and the slot of the next one
  bool has_last_ = false;
};

}  // namespace drench::kokkos_backend
