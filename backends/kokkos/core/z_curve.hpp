#pragma once
// What lies together in space, together in order.

#include <vector>

#include "base/types.hpp"

namespace drench::kokkos_backend {

/// The points' numbers along a Z-curve through cells of edge `cell` (m), a `part` after the other (the cloths, say).
std::vector<Index> along_z_curve(const std::vector<Vec3>& point, const std::vector<Index>& part, double cell);

}  // namespace drench::kokkos_backend
