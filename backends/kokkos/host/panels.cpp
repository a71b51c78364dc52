#include "host/panels.hpp"

#include <algorithm>
#include <cmath>

#define DRENCH_ISA_FILE "host/panels.inl"
#include "host/for_each_isa.hpp"

namespace drench::kokkos_backend {

const PanelLoops& panel_loops() { return DRENCH_BY_ISA(loops); }

}  // namespace drench::kokkos_backend
