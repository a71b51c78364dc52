#pragma once
// The particles' shapes in the liquid's field: balls, or ellipsoids that lie along the surface (Yu and Turk 2013).

#include <vector>

#include "base/types.hpp"

namespace drench {

/// A particle as the surface sees it. Its kernel is 315/(64 π a b c) (1 − q²)³ with q² = rᵀ M r; a, b, c are its
/// semi-axes.
struct Blob {
  Vec3 x;                        // m, of the kernel's middle
  double share;                  // V_j · 315/(64 π a b c), 1
  double density;                // δ_j, 1
  double enough;                 // δ_j from which V_j is m_j/ρ₀ and no more, 1
  std::array<double, 6> metric;  // 1/m², of M: xx yy zz yz xz xy
  Vec3 reach;                    // m, half of the box around it
  bool round;                    // a ball
  Index particle;                // index into the state

  /// q² at x + r.
  double square(const Vec3& r) const {
    const auto& m = metric;
    if (round) return m[0] * (r[0] * r[0] + r[1] * r[1] + r[2] * r[2]);
    return m[0] * r[0] * r[0] + m[1] * r[1] * r[1] + m[2] * r[2] * r[2] +
           2 * (m[3] * r[1] * r[2] + m[4] * r[0] * r[2] + m[5] * r[0] * r[1]);
  }
};

/// What a kernel is made from.
struct SurfaceParticle {
  Vec3 x;          // m
  double full;     // m_j/m_0, 1
  double size;     // m, the larger of its own spacing d_j and 1.4 Δ
  Index particle;  // index into the state
};

/// A ball of radius 2 d_j around each particle. `spacing` is d, m.
std::vector<Blob> round_kernels(const std::vector<SurfaceParticle>& particles, double spacing);

/// Ellipsoids of the same volume where the neighborhood is flat or long, and balls elsewhere; the middles are smoothed
/// (docs/dev/liquid_surface.md). The same bits for any number of threads.
std::vector<Blob> anisotropic_kernels(const std::vector<SurfaceParticle>& particles, double spacing, int threads);

}  // namespace drench
