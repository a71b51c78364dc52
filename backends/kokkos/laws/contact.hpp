#pragma once
// Contact with the analytic bodies: boxes, containers, spheres and planes. Meshes act through their samples only.

#include "device.hpp"

namespace drench::kokkos_backend {

/// Signed distance φ (m, positive on the free side) and its gradient, the unit normal towards the free side.
struct SolidDistance {
  Real phi;
  Real3 normal;
};

/// Distance to a box: exact outside (Quilez), to the nearest face inside. `lo` = min − x and `hi` = x − max, m.
KOKKOS_INLINE_FUNCTION SolidDistance box_distance(const Real3& lo, const Real3& hi) {
  const Real low[3] = {lo.x, lo.y, lo.z}, high[3] = {hi.x, hi.y, hi.z};
  Real beyond[3], side[3], normal[3] = {0, 0, 0}, square = 0;
  int axis = 0;
  for (int a = 0; a < 3; ++a) {
    side[a] = high[a] >= low[a] ? Real(1) : Real(-1);
    beyond[a] = high[a] >= low[a] ? high[a] : low[a];
    if (beyond[a] > beyond[axis]) axis = a;
    if (beyond[a] > 0) square += beyond[a] * beyond[a];
  }
  const Real distance = Kokkos::sqrt(square);
  if (!(distance > 0)) {
    normal[axis] = side[axis];
    return {beyond[axis], {normal[0], normal[1], normal[2]}};
  }
  for (int a = 0; a < 3; ++a)
    if (beyond[a] > 0) normal[a] = side[a] * beyond[a] / distance;
  return {distance, {normal[0], normal[1], normal[2]}};
}

/// Distance of the point x + shift to a solid; the two are kept apart so that small shifts keep their digits in floats.
KOKKOS_INLINE_FUNCTION SolidDistance solid_distance(const Solid& solid, const Real3& x, const Real3& shift) {
  if (solid.kind == 0) {
    SolidDistance box = box_distance((solid.min - x) - shift, (x - solid.max) + shift);
    if (solid.inside) box = {-box.phi, -box.normal};
    return box;
  }
  if (solid.kind == 1) {
    const Real3 out = (x - solid.center) + shift;
    const Real r = norm(out);
    return {r - solid.radius, r > 0 ? (1 / r) * out : Real3{0, 1, 0}};
  }
  if (solid.kind == 2) return {dot(x - solid.point, solid.normal) + dot(shift, solid.normal), solid.normal};
  return {Real(1e30), {0, 0, 0}};
}

/// Moves x + shift out of all solids, in their order, to the distance τ (m) where it is nearer; returns the new shift.
KOKKOS_INLINE_FUNCTION Real3 project_out(const Array<Solid>& solids, const Real3& x, Real3 shift, Real thickness) {
  for (std::size_t b = 0; b < solids.extent(0); ++b) {
    const SolidDistance d = solid_distance(solids(b), x, shift);
    if (d.phi < thickness) shift += (thickness - d.phi) * d.normal;
  }
  return shift;
}

/// v − n min(0, v·n): without the part that goes into the solid.
KOKKOS_INLINE_FUNCTION Real3 without_inward(const Real3& v, const Real3& normal) {
  const Real inward = dot(v, normal);
  return inward < 0 ? v - inward * normal : v;
}

/// Coulomb: the tangential velocity (m/s, relative to a normal at rest) loses at most `loss` (m/s).
KOKKOS_INLINE_FUNCTION Real3 with_friction(const Real3& v, const Real3& normal, Real loss) {
  const Real3 along = dot(v, normal) * normal;
  const Real3 tangential = v - along;
  const Real speed = norm(tangential);
  return speed > loss ? along + (1 - loss / speed) * tangential : along;
}

}  // namespace drench::kokkos_backend
