#pragma once
// The smoothing kernels; laws and sources in src/stages/kernel.hpp.

#include "core/types.hpp"
#include "scene/scene.hpp"

namespace drench::kokkos_backend {

/// The kernel of a scene. All pairs take the same branch on its kind, which costs nothing measurable; a formula without
/// branches for all three takes a quarter more time for the density than the cubic spline with them.
struct Kernel {
  KernelKind kind;
  Real h, inverse_h;       // m, 1/m
  Real sigma, grad_scale;  // 1/m³: of W; 1/m⁵: of (dW/dr)/r
  Real steepest;           // m: where |dW/dr| is largest

  Kernel(KernelKind which, Real support) : kind(which), h(support), inverse_h(1 / support) {
    constexpr double pi = 3.14159265358979323846;
    const double square = double(support) * double(support), volume = square * double(support);
    double norm = 8 / pi, grad_norm = 6 * norm;
    if (which == KernelKind::wendland) {
      norm = 21 / (2 * pi);
      grad_norm = 20 * norm;
    } else if (which == KernelKind::poly6) {
      norm = 315 / (64 * pi);
      grad_norm = 45 / pi;
    }
    steepest = which == KernelKind::cubic ? support / 3 : which == KernelKind::wendland ? support / 4 : Real(0);
    sigma = Real(norm / volume);
    grad_scale = Real(grad_norm / (volume * square));
  }

  /// W(r), 1/m³.
  KOKKOS_INLINE_FUNCTION Real value(Real r) const {
    const Real q = r * inverse_h;
    if (q >= 1) return 0;
    const Real p = 1 - q;
    if (kind == KernelKind::cubic) return q <= Real(0.5) ? sigma * (6 * q * q * (q - 1) + 1) : sigma * 2 * p * p * p;
    if (kind == KernelKind::wendland) return sigma * (p * p) * (p * p) * (4 * q + 1);
    const Real s = p * (1 + q);
    return sigma * s * s * s;
  }
  /// (dW/dr)/r, 1/m⁵, so that ∇W_ij = grad_factor(r) (x_i − x_j). Finite at r = 0.
  KOKKOS_INLINE_FUNCTION Real grad_factor(Real r) const {
    const Real q = r * inverse_h;
    if (q >= 1) return 0;
    const Real p = 1 - q;
    if (kind == KernelKind::cubic) return q <= Real(0.5) ? grad_scale * (3 * q - 2) : -grad_scale * p * p / q;
    if (kind == KernelKind::wendland) return -grad_scale * p * p * p;
    return q > Real(1e-9) ? -grad_scale * p * p / q : Real(0);
  }
  /// ∇W at r, 1/m⁴; not held at its steepest.
  KOKKOS_INLINE_FUNCTION Real3 gradient(const Real3& r) const {
    const Real square = dot(r, r);
    if (!(square > Real(1e-18) * h * h)) return {};
    const Real inverse = inverse_root(square), q = square * inverse * inverse_h, p = 1 - q;
    if (q >= 1) return {};
    if (kind == KernelKind::cubic)
      return (q <= Real(0.5) ? grad_scale * (3 * q - 2) : -grad_scale * p * p * (inverse * h)) * r;
    if (kind == KernelKind::wendland) return (-grad_scale * p * p * p) * r;
    return (-grad_scale * p * p * (inverse * h)) * r;
  }
  /// Of two liquid particles at a distance r < h, given r²: r, W and (dW/dr)/r, the gradient held at its steepest.
  struct Pair {
    Real length, value, grad_factor;
  };
  KOKKOS_INLINE_FUNCTION Pair pair(Real square) const {
    const bool coincide = !(square > Real(1e-18) * h * h);
    const Real inverse = coincide ? Real(0) : inverse_root(square), r = square * inverse;
    if (kind == KernelKind::cubic) {  // in truncated powers: branches that cannot be foreseen cost more
      const Real q = r * inverse_h, p = 1 - q, t = q < Real(0.5) ? Real(0.5) - q : Real(0);
      const Real steep = q < Real(1.0 / 3) ? Real(1.0 / 3) : p * p - 4 * t * t;
      return {r, 2 * sigma * (p * p * p - 4 * t * t * t), -grad_scale * steep * (inverse * h)};
    }
    if (!(r < steepest)) return {r, value(r), grad_factor(r)};
    return {r, value(r), steepest * inverse * grad_factor(steepest)};
  }
};

/// (dW/dr)/r of two liquid particles over Kernel::grad_scale, 1, with the sign turned: what Kernel::pair has, in fewer
/// instructions, for lists that keep no factors. Any unit of length that `support` is in.
struct PairSlope {
  Real inverse_h, h, trace;  // trace: of h², so that the root of two coincident particles is finite
  Real held;                 // of h: from here inwards (dW/dr) is held
  Real inner;                // 1 where the kernel has an inner part as the cubic spline's, else 0
  bool wendland;

  PairSlope(KernelKind kind, Real support)
      : inverse_h(1 / support),
        h(support),
        trace(Real(1e-12) * support * support),
        held(kind == KernelKind::cubic      ? Real(1.0 / 3)
             : kind == KernelKind::wendland ? Real(0.25)
                                            : Real(0)),
        inner(kind == KernelKind::cubic ? 1 : 0),
        wendland(kind == KernelKind::wendland) {}
  /// At r² ≤ h².
  KOKKOS_INLINE_FUNCTION Real operator()(Real square) const {
#if defined(__CUDA_ARCH__) && !defined(DRENCH_DOUBLE)
    float inverse;
    asm("rsqrt.approx.ftz.f32 %0, %1;" : "=f"(inverse) : "f"(square + trace));
#else
    const Real inverse = inverse_root(square + trace);
#endif
    const Real c = larger(square * inverse * inverse_h, held), p = 1 - c;
    const Real t = larger(fused<Real>(-2, c, 1), Real(0));
    Real steep = fused(-inner * t, t, p * p);
    if (wendland) steep *= p * c;
    return steep * (h * inverse);
  }
};

}  // namespace drench::kokkos_backend
