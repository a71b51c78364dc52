#pragma once
// What preconditions the cloth's iterations on a host: two matrices of Projective Dynamics, one along the sheet and one across
// it, factored (docs/theory/cloth.md, section 8).

#include <memory>
#include <vector>

#include "core/types.hpp"

namespace drench::kokkos_backend {

struct Cloth;
struct ClothSystem;

/// z = n C⁻¹ nᵀr + (1 − n nᵀ) A⁻¹ (1 − n nᵀ) r with the nodes' normals n, over the free nodes.
/// A = M/Δt² + Σ_c w_c A_cᵀA_c, N/m, bounds the Hessian along the sheet; in it M/Δt² and the strain damping are rounded up to
/// half powers of two, so that it stays for many steps. C is the Hessian across the sheet at an iterate.
/// Both depend on the state alone, so that a run that is resumed computes the same bits.
class PdPreconditioner {
 public:
  PdPreconditioner(const Cloth& cloth, const ClothSystem& system);
  ~PdPreconditioner();
  PdPreconditioner(const PdPreconditioner&) = delete;
  PdPreconditioner& operator=(const PdPreconditioner&) = delete;

  /// A for the masses and the time step of `system`.
  void update(const Cloth& cloth, const ClothSystem& system);
  /// n and C at x⁰ + `shift`, m.
  void update_across(const Cloth& cloth, const ClothSystem& system, const Entries<const Real3>& shift);
  /// r in N, z in m, both per node; pinned nodes keep their z. `safe`: z = A⁻¹ r, with which a plain step always descends.
  void apply(const Entries<const Real3>& r, const Entries<Real3>& z, bool safe);

 private:
  // a number for each of x, y, z along the sheet, and one across it
  using Lanes [[gnu::vector_size(4 * sizeof(Real))]] = Real;
  struct Assembly;

  void find_normals(const Cloth& cloth, const ClothSystem& system, const Entries<const Real3>& shift);
  void keep_pattern();
  /// Factors what was assembled and puts the numbers into lanes [first, last).
  void keep_factor(int first, int last);

  std::unique_ptr<Assembly> assembly_;
  std::vector<int> inertia_step_;  // of each free node, and of the strain damping: half powers of two
  std::vector<Real3> normal_;  // of each node
  // the factors by columns in the order of elimination, and which node that is
  std::vector<Index> node_, column_start_, row_;
  std::vector<Lanes> factor_, inverse_diagonal_, solution_;
};

}  // namespace drench::kokkos_backend
