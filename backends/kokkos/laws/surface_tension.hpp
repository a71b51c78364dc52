#pragma once
// Pair forces of surface tension and adhesion; laws and sources in src/stages/surface_tension.hpp.

#include "scene/scene.hpp"
#include "types.hpp"
#include <cstdlib>

namespace drench::kokkos_backend {

/// Cohesion A C(r) and surface term B of liquid of tension σ, and the shape of adhesion.
struct SurfaceForces {
  Real h, inverse_h;
  Real cohesion_factor;  // A · 32/(π h³), N/m⁶
  Real surface;          // B, N/m⁶
  Real adhesion_factor;  // 0.007/h³, 1/m³

  SurfaceForces(KernelKind kernel, double sigma, double support) : h(Real(support)), inverse_h(Real(1 / support)) {
    constexpr double pi = 3.14159265358979323846;
    const double share = std::getenv("FL_BETA") ? std::atof(std::getenv("FL_BETA")) : surface_share;
    const double h2 = support * support, h3 = h2 * support;
    const double k = kernel == KernelKind::cubic      ? 969 * pi / 8960
                     : kernel == KernelKind::wendland ? 29 * pi / 264
                                                      : 61 * pi / 560;
    cohesion_factor = Real((1 - share) * sigma * 7040 / (21 * h2) * 32 / (pi * h3));
    surface = Real(share * sigma / (k * h2 * h3));
    adhesion_factor = Real(0.007 / h3);
  }

  /// A C(r), N/m⁶: positive where the pair attracts.
  KOKKOS_INLINE_FUNCTION Real cohesion(Real r) const {
    const Real q = r * inverse_h;
    if (q >= 1) return 0;
    const Real s = (1 - q) * q, cube = s * s * s;
    return cohesion_factor * (q > Real(0.5) ? cube : 2 * cube - Real(1.0 / 64));
  }
  /// a(r), 1/m³.
  KOKKOS_INLINE_FUNCTION Real adhesion(Real r) const {
    const Real q = r * inverse_h;
    const Real inside = (4 * q - 2) * (1 - q);
    return q > Real(0.5) && inside > 0 ? adhesion_factor * Kokkos::sqrt(Kokkos::sqrt(inside)) : Real(0);
  }

  static constexpr double surface_share = 0.5;  // β
};

/// D_b, N/m³, of a wall whose samples stand for `layer` m³ each on an even plane of spacing d; `work` of adhesion w, N/m.
inline double adhesion_strength(double work, double layer, double d, double h) {
  constexpr double pi = 3.14159265358979323846;
  constexpr double m0 = 0.3090124462168954;
  const double j = m0 * (207 * h / 1344 - 65 * d / 448 + d * d * d / (48 * h * h));
  return work * d * d / (0.007 * 2 * pi * j * layer);
}

}  // namespace drench::kokkos_backend
