#pragma once
// The matrix of Projective Dynamics, factored on the host: what preconditions the cloth's iterations there
// (docs/theory/cloth.md, section 9).

#include <memory>
#include <vector>

#include "core/types.hpp"

namespace drench::kokkos_backend {

struct Cloth;
struct ClothSystem;

/// L D Lᵀ of A = M/Δt² + Σ_c w_c A_cᵀA_c over the free nodes, N/m. M/Δt² and the strain damping stand in it rounded up to
/// half powers of two: A bounds the Hessian, and is made anew only where a node's inertia has moved on by a step.
/// What is kept depends on the state alone, so that a run that is resumed computes the same bits.
class PdFactor {
 public:
  PdFactor(const Cloth& cloth, const ClothSystem& system);
  ~PdFactor();
  PdFactor(const PdFactor&) = delete;
  PdFactor& operator=(const PdFactor&) = delete;

  /// For the masses and the time step of `system`.
  void update(const Cloth& cloth, const ClothSystem& system);
  /// z = A⁻¹ r of the free nodes (r in N, z in m, both per node); pinned nodes keep their z.
  void solve(const Entries<const Real3>& r, const Entries<Real3>& z) const;
  /// Entries of L below its diagonal.
  std::size_t entries() const { return row_.size(); }

 private:
  struct Assembly;
  void keep_factor();

  std::unique_ptr<Assembly> assembly_;
  std::vector<int> inertia_step_;  // of each free node, and of the strain damping: half powers of two
  // L by columns in the order of elimination, and who is eliminated when
  std::vector<Index> node_, column_start_, row_;
  std::vector<Real> factor_, inverse_diagonal_;
};

}  // namespace drench::kokkos_backend
