#pragma once
// Stage wet_adhesion. Law: src/stages/wet_adhesion.hpp.

#include "cloth/cloth.hpp"

namespace drench::kokkos_backend {

/// Work arrays, made on first use. `impulse` is zero between steps.
struct WetAdhesionWork {
  Real thickness = 0;           // m: the largest
  Field<Real> area;             // per node: A_n, m²
  Index triangles = 0;          // of cloths with self_collision
  Field<Index> triangle;        // 3 each
  Field<Real3> center;          // of each, m
  CellTable cells;              // of these
  Field<std::int64_t> impulse;  // 3 per node, units of q · 2^-20 m/s
};

MemoryEstimate wet_adhesion_bytes(const Sizing& s);

void wet_adhesion(const Constants& constants, Bodies& bodies, Cloth& cloth, WetAdhesionWork& work,
                  const StepInfo& info);

}  // namespace drench::kokkos_backend
