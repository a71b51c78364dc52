#pragma once
// Loops over arrays of the host, also in a build whose kernels run on a GPU.

#include "core/types.hpp"

namespace drench::kokkos_backend {

/// Runs body(i) for i in [0, n): by parallel() where kernels run on the host, else on the threads of the GPU's host,
/// each of which takes neighbouring indexes.
template <class Body>
void host_parallel(const char* label, Index n, const Body& body) {
  if (n <= 0) return;
  if constexpr (on_host) {
    parallel(label, n, body);
  } else {
    static thread_local LoopTime time;
    run_timed(
        time, n,
        [&] {
          for (Index i = 0; i < n; ++i) body(i);
        },
        [&] {
#ifdef _OPENMP
#pragma omp parallel for schedule(static) num_threads(HostLoops::threads())
#endif
          for (Index i = 0; i < n; ++i) body(i);
        });
  }
}

}  // namespace drench::kokkos_backend
