#pragma once
// Pair forces of surface tension and adhesion; laws and sources in src/stages/surface_tension.hpp.

#include "core/kernel.hpp"

namespace drench::kokkos_backend {

/// Cohesion and area term of liquid of tension σ.
struct Cohesion {
  Kernel kernel;
  Real pressure;    // A, Pa
  Real area;        // B/h², N/m⁸
  Real inverse_h2;  // 1/m²

  Cohesion(const Kernel& of_scene, double sigma, double h) : kernel(of_scene) {
    constexpr double pi = 3.14159265358979323846;
    double c = 31.0 / 560, k = 65441 * pi / 11354112;  // cubic
    if (kernel.kind == KernelKind::wendland) {
      c = 5.0 / 96;
      k = 2557 * pi / 443520;
    } else if (kernel.kind == KernelKind::poly6) {
      c = 3.0 / 56;
      k = 263 * pi / 45760;
    }
    constexpr double area_share = 0.78;  // β
    pressure = Real((1 - area_share) * sigma / (c * h));
    area = Real(area_share * sigma / (k * h * h * h * h * h * h * h));
    inverse_h2 = Real(1 / (h * h));
  }

  /// F_ij/(V_i V_j) is this times x_i − x_j = r, N/m⁷; `turn` = n_i − n_j.
  KOKKOS_INLINE_FUNCTION Real pull(const Real3& r, const Real3& turn) const {
    const Real r2 = dot(r, r), inside = 1 - r2 * inverse_h2;
    return pressure * kernel.grad_factor(Kokkos::sqrt(r2)) - (inside > 0 ? area * inside * dot(turn, r) : Real(0));
  }
};

/// Akinci's adhesion kernel a(r), 1/m³.
struct Adhesion {
  Real inverse_h;
  Real factor;  // 0.007/h³, 1/m³

  explicit Adhesion(double h) : inverse_h(Real(1 / h)), factor(Real(0.007 / (h * h * h))) {}

  KOKKOS_INLINE_FUNCTION Real value(Real r) const {
    const Real q = r * inverse_h;
    const Real inside = (4 * q - 2) * (1 - q);
    return q > Real(0.5) && inside > 0 ? factor * Kokkos::sqrt(Kokkos::sqrt(inside)) : Real(0);
  }
};

/// D, N/m³, of a wall with `work` of adhesion w, N/m, whose samples stand for a layer of liquid (density.hpp).
inline double adhesion_strength(double work, double d, double h) {
  constexpr double pi = 3.14159265358979323846;
  constexpr double m0 = 0.3090124462168954;
  const double j = m0 * (207 * h / 1344 - 65 * d / 448 + d * d * d / (48 * h * h));
  return work / (0.007 * 2 * pi * j * d);
}

}  // namespace drench::kokkos_backend
