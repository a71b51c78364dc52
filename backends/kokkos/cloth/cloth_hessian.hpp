#pragma once
// The Hessian of the cloth's implicit step at an iterate, factored, on a host (docs/theory/cloth.md, section 8).

#include <vector>

#include "cloth/block_cholesky.hpp"

namespace drench::kokkos_backend {

struct Cloth;
struct ClothSystem;

/// H = M/Δt² − ∂f/∂x over the free nodes, N/m, without what is negative in it.
class ClothHessian {
 public:
  /// Exists unless a factorisation takes more multiplications than `most_work`.
  ClothHessian(const Cloth& cloth, const ClothSystem& system, double most_work);
  bool exists() const { return !own_.empty(); }
  /// H at x⁰ + `shift`, m, factored.
  void update(const Cloth& cloth, const ClothSystem& system, const Entries<const Real3>& shift);
  /// z = H⁻¹ r: r in N, z in m, per node; pinned nodes keep their z.
  void apply(const Entries<const Real3>& r, const Entries<Real3>& z);

 private:
  /// A block of the factor; stride 0: none.
  struct Target {
    std::uint32_t at = 0;
    Index stride = 0;
  };
  Target target(Index row, Index column) const;

  std::vector<Index> free_;   // nodes by their rows
  std::vector<Index> row_of_;  // of each node; −1: pinned
  BlockCholesky factor_;
  std::vector<Target> own_, shared_, of_triangle_;  // of each node; of each link; 3 of each corner with a limit or a membrane
  std::vector<Real> solution_;
};

}  // namespace drench::kokkos_backend
