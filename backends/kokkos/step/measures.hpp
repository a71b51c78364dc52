#pragma once
// Stage measures (src/stages/measures.hpp).

#include "cloth/cloth.hpp"
#include "particles/fluid.hpp"

namespace drench::kokkos_backend {

struct MeasuresWork {
  CellTable cells;        // of the liquid
  Field<Real> nearest;    // 2 per liquid particle: m; 1
  Field<double> rest_uv;  // 2 per node: (u, v), m
};

MemoryEstimate measures_bytes(const Sizing& s);

void measures(const Constants& constants, Fluid& fluid, const Cloth& cloth, MeasuresWork& work, StepReport& report);

}  // namespace drench::kokkos_backend
