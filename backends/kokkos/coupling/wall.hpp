#pragma once
// How walls stand before the liquid: solids and thin sheets as mirrors, a sheet on whichever side the particle is.

#include "core/types.hpp"

namespace drench::kokkos_backend {

/// A wall stands for the mirrored liquid: pressure κ_i + κ_i, velocity v_i − v_b twice (src/stages/divergence.hpp).
inline constexpr Real mirrored = 2;

/// γ of a particle before a cloth: how dense the mirrored liquid is, of its density ratio (src/stages/divergence.hpp).
KOKKOS_INLINE_FUNCTION Real image_density(Real ratio) { return ratio > Real(1.1) ? ratio - Real(0.1) : Real(1); }

/// L a of a symmetric L, xx yy zz and yz xz xy.
KOKKOS_INLINE_FUNCTION Real3 product(const Real3& diagonal, const Real3& shear, const Real3& a) {
  return {diagonal.x * a.x + shear.z * a.y + shear.y * a.z, shear.z * a.x + diagonal.y * a.y + shear.x * a.z,
          shear.y * a.x + shear.x * a.y + diagonal.z * a.z};
}

/// L⁻¹ a of the same.
KOKKOS_INLINE_FUNCTION Real3 over_gain(const Real3& diagonal, const Real3& shear, const Real3& a) {
  const Real3 x{diagonal.x, shear.z, shear.y}, y{shear.z, diagonal.y, shear.x}, z{shear.y, shear.x, diagonal.z};
  const Real3 yz = cross(y, z), zx = cross(z, x), xy = cross(x, y);
  return (1 / dot(x, yz)) * Real3{dot(yz, a), dot(zx, a), dot(xy, a)};
}

/// Vector (m) to a particle from a cloth sample as the particle's pressure sees it: r + ½ d n sign(r·n), r = x_i − x_b,
/// `offset` = ½ d n with the unit normal n. The sample lies half a spacing behind the sheet's surface, as those of
/// solids do: on the surface a sheet's kernel sum has no gradient, and would not push particles back.
KOKKOS_INLINE_FUNCTION Real3 from_behind(const Real3& r, const Real3& offset) {
  return dot(r, offset) < 0 ? r - offset : r + offset;
}

}  // namespace drench::kokkos_backend
