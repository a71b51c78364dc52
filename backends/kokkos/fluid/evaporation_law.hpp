#pragma once
// Area of the liquid's free surface (docs/theory/evaporation.md, section 4).

#include "core/kernel.hpp"

namespace drench::kokkos_backend::laws {

/// What is around a particle.
struct Colour {
  Real liquid = 0, solid = 0;             // Σ V W, 1
  Real number = 0;                        // Σ W of the liquid, 1/m³
  Real moment = 0;                        // M, 1: −⅓ Σ V r·∇W
  Real3 liquid_gradient, solid_gradient;  // 1/m
  Index near = 0;                         // that it is summed over

  KOKKOS_INLINE_FUNCTION void add_liquid(const Kernel& kernel, Real volume, const Real3& r) {
    const Real length = norm(r), w = kernel.value(length), factor = volume * kernel.grad_factor(length);
    liquid_gradient += factor * r;
    moment -= Real(1.0 / 3) * factor * length * length;
    liquid += volume * w;
    number += w;
    ++near;
  }
  KOKKOS_INLINE_FUNCTION void add_solid(const Kernel& kernel, Real volume, const Real3& r) {
    const Real length = norm(r), factor = volume * kernel.grad_factor(length);
    solid_gradient += factor * r;
    moment -= Real(1.0 / 3) * factor * length * length;
    solid += volume * kernel.value(length);
    ++near;
  }
  /// ∇c, 1/m, and c, 1: of the room that solids leave.
  KOKKOS_INLINE_FUNCTION Real4 of_room() const {
    constexpr Real least = Real(0.2);
    const Real inverse = 1 / larger(least, larger(1 - solid, liquid)), c = liquid * inverse;
    return {inverse * (liquid_gradient + c * solid_gradient), c};
  }
};

/// The law's constants for a kernel and a spacing.
struct Surface {
  Real full;       // d³, m³
  Real film;       // ω d/h, 1: how full a film of one layer is
  Real film_area;  // 2 d² ω d/h, m²
  Real depth;      // 2 z̄, m
  Real smooth;     // 15/(8 π h³), 1/m³
  Real support;    // h, m

  Surface(KernelKind kind, double d, double h)
      : full(Real(d * d * d)), smooth(Real(15 / (8 * 3.14159265358979323846 * h * h * h))), support(Real(h)) {
    const bool wendland = kind == KernelKind::wendland, poly6 = kind == KernelKind::poly6;
    const double plane = (wendland ? 3.0 / 2 : poly6 ? 315.0 / 256 : 7.0 / 5) * d / h;
    film = Real(plane);
    film_area = Real(2 * d * d * plane);
    depth = Real(2 * h * (wendland ? 5.0 / 24 : poly6 ? 3.0 / 14 : 31.0 / 140));
  }

  /// The outward normal, 1, and how far the flat law holds, 0 to 1, of the mean gradient N, 1/m, and c.
  KOKKOS_INLINE_FUNCTION Real4 normal(const Real3& mean, Real c) const {
    constexpr Real inside = Real(0.11), at_surface = Real(0.17);
    const Real length = norm(mean), steep = length * support / (c * c);
    if (!(steep > inside)) return {Real3{}, 0};
    const Real share = (steep - inside) / (at_surface - inside);
    return {(-1 / length) * mean, share < 1 ? share : Real(1)};
  }
  /// F, m², of a particle of volume V: what the gradient tells, below 0 where it points inwards. `steep` = −∇c·n, 1/m,
  /// and H the mean curvature, 1/m.
  KOKKOS_INLINE_FUNCTION Real flat_area(Real volume, Real steep, Real curvature) const {
    constexpr Real most_bent = 3;
    const Real bent = 1 + depth * curvature;
    return bent > 0 ? 2 * volume * steep * (bent < most_bent ? bent : most_bent) : Real(0);
  }
  /// Both sides of a particle in a film, m², and the share of them that solids leave open, 1; as in Colour.
  KOKKOS_INLINE_FUNCTION Real both_sides(Real number) const { return film_area / (full * number); }
  KOKKOS_INLINE_FUNCTION Real open(Real solid) const { return 1 - (solid < Real(0.25) ? 2 * solid : Real(0.5)); }
  /// How full a particle's surroundings are, 1.
  KOKKOS_INLINE_FUNCTION Real filled(Real number, Real solid) const { return full * number + solid; }
  /// How far a particle counts as one of a film of one layer, or as loose, 0 to 1.
  KOKKOS_INLINE_FUNCTION Real thin(Real filled) const {
    return within_unit(Real(4.0 / 3) - 2 * (filled - film) / (1 - film));
  }
  KOKKOS_INLINE_FUNCTION Real loose(Real filled) const { return within_unit(Real(5.5) - 7 * filled / film); }
  /// How far a steepness (1/m) does not explain what is not filled, 0 to 1.
  KOKKOS_INLINE_FUNCTION Real unexplained(Real filled, Real steep) const {
    const Real empty = filled < Real(0.95) ? 1 - filled : Real(0.05);
    return within_unit(8 - 4 * support * steep / empty);
  }

 private:
  KOKKOS_INLINE_FUNCTION static Real within_unit(Real x) { return x < 0 ? Real(0) : x < 1 ? x : Real(1); }
};

/// (36 π)^⅓ V^⅔ of a volume in m³.
KOKKOS_INLINE_FUNCTION Real round_drop_area(Real volume) {
  const Real edge = Kokkos::cbrt(volume);
  return Real(4.835975862049408) * edge * edge;
}

}  // namespace drench::kokkos_backend::laws
