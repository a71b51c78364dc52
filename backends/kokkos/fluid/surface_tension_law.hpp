#pragma once
// Pair forces of surface tension and adhesion; laws and sources in src/stages/surface_tension.hpp.

#include "core/kernel.hpp"

namespace drench::kokkos_backend {

inline constexpr double area_share = 0.78;  // β_σ

/// Kernel integrals c_W and k_W.
struct TensionIntegrals {
  double cohesion, area;
};
inline TensionIntegrals tension_integrals(KernelKind kind) {
  constexpr double pi = 3.14159265358979323846;
  if (kind == KernelKind::wendland) return {5.0 / 96, 2557 * pi / 443520};
  if (kind == KernelKind::poly6) return {3.0 / 56, 263 * pi / 45760};
  return {31.0 / 560, 65441 * pi / 11354112};
}

/// Cohesion and area term of liquid of tension σ.
struct Cohesion {
  Kernel kernel;
  Real pressure;    // A, Pa
  Real area;        // B/h², N/m⁸
  Real inverse_h2;  // 1/m²

  Cohesion(const Kernel& of_scene, double sigma, double h) : kernel(of_scene) {
    const auto [c, k] = tension_integrals(kernel.kind);
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

/// A_b, Pa, of a wall with `work` of adhesion w, N/m.
inline double wall_cohesion(KernelKind kind, double work, double sigma, double h) {
  constexpr double wall_share = 0.88;  // β_w
  const double all = work / (tension_integrals(kind).cohesion * h);
  return sigma > 0 ? wall_share * (1 - area_share) * all : all / 2;
}

}  // namespace drench::kokkos_backend
