#pragma once
// Dense loops over a panel of a Cholesky factor, in the vector registers of this processor. The file does not see
// Kokkos, so a build for a GPU compiles it as others do (CMakeLists.txt).

#include "host/real.hpp"

namespace drench::kokkos_backend {

/// Numbers of a panel's column that are subtracted from neighbouring ones of another.
struct PanelRun {
  Index source, target, length;
};

/// Described in host/panels.inl.
struct PanelLoops {
  void (*factor_panel)(Real* a, Index columns, Index stride, Real* inverse_pivot);
  void (*invert_panel)(const Real* a, Index columns, Index stride, Index top, const Real* inverse_pivot, Real* inverse);
  using Products = void (*)(const Real* a, Index columns, Index stride, Index row, Index from, Index to, Real* out,
                            Index out_stride);
  Products products_of_3, products_of_6;
  using SubtractRuns = void (*)(const Real* products, Index stride, const PanelRun* run, const PanelRun* end,
                                Real* const* to);
  SubtractRuns subtract_runs_of_3, subtract_runs_of_6;
  using TimesVector = void (*)(const Real* a, Index columns, Index stride, Index rows, const Real* x, Real* out);
  TimesVector panel_times, subtract_transposed;
};
/// Those of the best instruction set (best_isa).
const PanelLoops& panel_loops();

}  // namespace drench::kokkos_backend
