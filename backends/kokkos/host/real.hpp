#pragma once
// The precision of the kernels. Files that do not see Kokkos need it too.

#include "base/types.hpp"
#include "drench_precision.hpp"

namespace drench::kokkos_backend {

#ifdef DRENCH_DOUBLE
using Real = double;
#else
using Real = float;
#endif

}  // namespace drench::kokkos_backend
