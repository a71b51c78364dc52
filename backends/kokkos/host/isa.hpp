#pragma once
// Which instruction sets the host's code is compiled for (host/for_each_isa.hpp), and which of them is run.

#include "host/real.hpp"

// Rows in vectors are a host's; a GPU's kernels have a thread a row. A build for a GPU compiles all files that see
// Kokkos by nvcc.
#ifndef __CUDACC__
#define DRENCH_LANES
#endif
// g++ compiles parts of a file for other processors by a pragma; clang has none that does.
#if defined(DRENCH_LANES) && defined(__x86_64__) && defined(__GNUC__) && !defined(__clang__)
#define DRENCH_SEVERAL_ISAS
#include <immintrin.h>
#endif

namespace drench::kokkos_backend {

/// A vector of numbers may be loaded where fewer are left: hosts' arrays have so many more.
inline constexpr int spare_lanes = 16;

enum class Isa { portable, avx2, avx512 };

/// The best one that this processor has; DRENCH_ISA=portable, avx2 or avx512 in the environment asks for one at most.
Isa best_isa();

/// One of three functions by best_isa(): DRENCH_BY_ISA(f) where isa_portable::f and its likes are.
#ifdef DRENCH_SEVERAL_ISAS
#define DRENCH_BY_ISA(function)                                                                         \
  (::drench::kokkos_backend::best_isa() == ::drench::kokkos_backend::Isa::avx512 ? isa_avx512::function \
   : ::drench::kokkos_backend::best_isa() == ::drench::kokkos_backend::Isa::avx2 ? isa_avx2::function   \
                                                                                 : isa_portable::function)
#else
#define DRENCH_BY_ISA(function) isa_portable::function
#endif

}  // namespace drench::kokkos_backend
