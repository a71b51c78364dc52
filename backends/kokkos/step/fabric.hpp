#pragma once
// Stage fabric (src/stages/fabric.hpp).

#include "cloth/cloth.hpp"

namespace drench::kokkos_backend {

struct FabricWork {
  Field<double> rest_uv;    // 2 per node: along warp and weft, m
  Field<double> rest_area;  // per triangle, m²
};

MemoryEstimate fabric_bytes(const Sizing& s);

void fabric(const Constants& constants, const Cloth& cloth, FabricWork& work, StepReport& report);

}  // namespace drench::kokkos_backend
