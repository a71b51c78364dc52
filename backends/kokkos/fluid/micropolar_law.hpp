#pragma once
// Spin of a particle against its surroundings; law and source in src/stages/micropolar.hpp.

#include "core/types.hpp"
#include "scene/scene.hpp"

namespace drench::kokkos_backend {

/// The law's numbers.
struct SpinLaw {
  Real half_transfer;  // ν_t/2, m²/s
  Real per_inertia;    // 1/Θ, 1/m²
  Real free;           // 1 − a, 1
  Real spread;         // 2 ζ, m²/s
  Real least;          // h/8, m: closer pairs spread as if they were so far apart

  SpinLaw(const MicropolarScene& scene, double spacing, double support)
      : half_transfer(Real(scene.transfer / 2)),
        per_inertia(Real(1 / (scene.inertia * spacing * spacing))),
        free(Real(1 - scene.reaction)),
        spread(Real(2 * scene.viscosity)),
        least(Real(support / 8)) {}

  /// A neighbour's weight in the spread of spin. b = V |∇W|/r, 1/m²; r in m.
  KOKKOS_INLINE_FUNCTION Real spreading(Real b, Real r) const { return r < least ? b * r / least : b; }
};

/// What a particle's neighbours tell it. With b = V_j |∇W_ij|/r (1/m²) and x = x_i − x_j (m):
struct SpinSum {
  Real3 curl;           // c = Σ b x × v_ij, 1/s
  Real3 spread;         // Σ b (ω_j − ω_i), 1/(m² s)
  Real3 diagonal, off;  // T = Σ b x xᵀ: xx, yy, zz and yz, zx, xy; 1
  Real steepness = 0;   // g = Σ b r, 1/m

  KOKKOS_INLINE_FUNCTION void add(Real b, const Real3& x, const Real3& velocity) {
    const Real3 y = b * x;
    curl += cross(y, velocity);
    diagonal += {y.x * x.x, y.y * x.y, y.z * x.z};
    off += {y.y * x.z, y.z * x.x, y.x * x.y};
    steepness += norm(y);
  }
  /// k = Σ b r², 1.
  KOKKOS_INLINE_FUNCTION Real trace() const { return diagonal.x + diagonal.y + diagonal.z; }
  /// Σ b x × (w × x) = k w − T w: c of a rigid rotation with w.
  KOKKOS_INLINE_FUNCTION Real3 rigid_curl(const Real3& w) const {
    const Real k = trace();
    return {(k - diagonal.x) * w.x - off.z * w.y - off.y * w.z, (k - diagonal.y) * w.y - off.x * w.z - off.z * w.x,
            (k - diagonal.z) * w.z - off.y * w.x - off.x * w.y};
  }
};

}  // namespace drench::kokkos_backend
