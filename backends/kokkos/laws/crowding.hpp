#pragma once
// How particles that are too close part (src/stages/advection.hpp, law 0).

#include "types.hpp"

namespace drench::kokkos_backend {

struct Crowding {
  Real widest;  // m: two full particles' s_ij

  explicit Crowding(Real spacing) : widest(Real(0.5) * spacing) {}

  /// Particle i's share of the pair's shift, m; r = x_i − x_j of length |r| < widest.
  KOKKOS_INLINE_FUNCTION Real3 shift(const Real3& r, Real length, Real volume_i, Real volume_j, std::int64_t id_i,
                                     std::int64_t id_j) const {
    const Real near = Real(0.25) * (Kokkos::cbrt(volume_i) + Kokkos::cbrt(volume_j));
    const Real both = volume_i + volume_j;
    if (!(length < near) || !(both > 0)) return {};
    Real3 axis;
    if (length < Real(2e-6) * widest) {
      const Real up = id_i > id_j ? Real(1) : Real(-1);
      const auto along = (id_i + id_j) % 3;
      (along == 0 ? axis.x : along == 1 ? axis.y : axis.z) = up;
    } else {
      axis = (1 / length) * r;
    }
    return (Real(0.1) * volume_j / both * (near - length)) * axis;
  }
};

}  // namespace drench::kokkos_backend
