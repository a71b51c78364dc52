#pragma once
// Stage wind. Contract: src/stages/wind.hpp.

#include "bodies/bodies.hpp"
#include "cloth/cloth.hpp"
#include "core/neighbor_list.hpp"
#include "particles/fluid.hpp"

namespace drench::kokkos_backend {

/// Constants of the cloth, made on first use; empty where none moves.
struct WindWork {
  Field<Real> areal_density;  // per cloth, kg/m²
  Field<Index> start, item;   // node → its triangles
};

MemoryEstimate wind_bytes(const Sizing& s);

void wind(const Constants& constants, Fluid& fluid, const NeighborLists& lists, const Bodies& bodies, Cloth& cloth,
          WindWork& work, const StepInfo& info);

}  // namespace drench::kokkos_backend
