#pragma once
// How coincident particles part (src/stages/advection.hpp, law 0).

#include "core/types.hpp"

namespace drench::kokkos_backend {

struct CoincidentPairs {
  Real least;  // m

  explicit CoincidentPairs(Real spacing) : least(Real(1e-3) * spacing) {}

  /// Particle i's share of the pair's displacement, m; r = x_i − x_j of length |r| < least.
  KOKKOS_INLINE_FUNCTION Real3 displacement(const Real3& r, Real length, Real volume_i, Real volume_j,
                                            std::int64_t id_i, std::int64_t id_j) const {
    const Real both = volume_i + volume_j;
    if (!(both > 0)) return {};
    Real3 axis;
    if (length < Real(1e-3) * least) {
      const Real up = id_i > id_j ? Real(1) : Real(-1);
      const auto along = (id_i + id_j) % 3;
      (along == 0 ? axis.x : along == 1 ? axis.y : axis.z) = up;
    } else {
      axis = (1 / length) * r;
    }
    return (volume_j / both * (least - length)) * axis;
  }
};

}  // namespace drench::kokkos_backend
