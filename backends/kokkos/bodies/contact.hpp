#pragma once
// Contact with the solid bodies, where they are at the end of the step. A mesh that is not closed has no distance: it acts
// through its samples only.

#include "bodies/bodies.hpp"
#include "bodies/nearest_point.hpp"

namespace drench::kokkos_backend {

/// Signed distance φ (m, positive on the free side), the unit normal towards the free side along its gradient, and how
/// fast φ grows along it: 1 but for a mesh's interpolated distance.
struct SolidDistance {
  Real phi;
  Real3 normal;
  Real slope = 1;
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

constexpr Real far_away = Real(1e30);  // m

/// Distance to a closed mesh from its field (trilinear), `x` relative to the centre in the body's own axes. Beyond the
/// lattice: far away.
KOKKOS_INLINE_FUNCTION SolidDistance field_distance(const Solid& s, const Real3& x) {
  if (s.field == nullptr) return {far_away, {0, 0, 0}};
  const Real at[3] = {(x.x - s.field_origin.x) / s.field_spacing, (x.y - s.field_origin.y) / s.field_spacing,
                      (x.z - s.field_origin.z) / s.field_spacing};
  Index cell[3];
  Real w[3];
  for (int a = 0; a < 3; ++a) {
    const Index last = s.field_points[a] - 1;
    if (!(at[a] >= 0 && at[a] <= Real(last))) return {far_away, {0, 0, 0}};
    cell[a] = static_cast<Index>(at[a]);
    if (cell[a] == last) --cell[a];
    w[a] = at[a] - Real(cell[a]);
  }
  Real phi = 0, slope[3] = {0, 0, 0};
  for (int corner = 0; corner < 8; ++corner) {
    const int on[3] = {corner & 1, corner >> 1 & 1, corner >> 2};
    const Real value =
        s.field[(static_cast<std::int64_t>(cell[2] + on[2]) * s.field_points[1] + cell[1] + on[1]) * s.field_points[0] +
                cell[0] + on[0]];
    Real part[3];
    for (int a = 0; a < 3; ++a) part[a] = on[a] ? w[a] : 1 - w[a];
    phi += part[0] * part[1] * part[2] * value;
    slope[0] += (on[0] ? value : -value) * part[1] * part[2];
    slope[1] += (on[1] ? value : -value) * part[0] * part[2];
    slope[2] += (on[2] ? value : -value) * part[0] * part[1];
  }
  const Real3 gradient{slope[0], slope[1], slope[2]};
  const Real length = norm(gradient);
  if (!(length > 0)) return {phi, {0, 1, 0}};
  return {phi, (1 / length) * gradient, Kokkos::fmax(length / s.field_spacing, Real(0.5))};
}

/// The vector with the components of `own` along a moving solid's axes.
KOKKOS_INLINE_FUNCTION Real3 to_world(const Solid& solid, const Real3& own) {
  return own.x * solid.axis[0] + own.y * solid.axis[1] + own.z * solid.axis[2];
}

/// Velocity (m/s) of the nearest point of a surface that changes its shape, from the triangle that the nearest lattice point
/// names; 0 beyond the band.
KOKKOS_INLINE_FUNCTION Real3 deforming_velocity(const Solid& s, const Real3& x) {
  const Real3 own = x - s.field_origin;
  const Real at[3] = {own.x / s.field_spacing, own.y / s.field_spacing, own.z / s.field_spacing};
  Index point[3];
  for (int a = 0; a < 3; ++a) {
    if (!(at[a] >= 0 && at[a] <= Real(s.field_points[a] - 1))) return {0, 0, 0};
    point[a] = static_cast<Index>(at[a] + Real(0.5));
  }
  const Index t = s.surface.nearest[(static_cast<std::int64_t>(point[2]) * s.field_points[1] + point[1]) *
                                        s.field_points[0] + point[0]];
  if (t < 0) return {0, 0, 0};
  const Index* const n = s.surface.corner + 3 * static_cast<std::int64_t>(t);
  const Real3* const p = s.surface.position;
  const Real3* const v = s.surface.velocity;
  const NearestPoint near = nearest_point(p[n[0]], p[n[1]], p[n[2]], own);
  return near.weight[0] * v[n[0]] + near.weight[1] * v[n[1]] + near.weight[2] * v[n[2]];
}

/// Velocity (m/s) of a solid's surface at x + shift.
KOKKOS_INLINE_FUNCTION Real3 surface_velocity(const Solid& solid, const Real3& x, const Real3& shift) {
  if (!solid.moves) return {0, 0, 0};
  if (solid.surface.nearest != nullptr) return deforming_velocity(solid, (x - solid.center) + shift);
  return solid.velocity + cross(solid.spin, (x - solid.center) + shift);
}

/// Distance of the point x + shift to a solid; the two are kept apart so that small shifts keep their digits in floats.
KOKKOS_INLINE_FUNCTION SolidDistance solid_distance(const Solid& solid, const Real3& x, const Real3& shift) {
  if (solid.kind == 3 || (solid.kind == 0 && solid.moves)) {
    const Real3 arm = (x - solid.center) + shift;
    const Real3 own =
        solid.moves ? Real3{dot(arm, solid.axis[0]), dot(arm, solid.axis[1]), dot(arm, solid.axis[2])} : arm;
    SolidDistance d = solid.kind == 3 ? field_distance(solid, own) : box_distance(-solid.half - own, own - solid.half);
    if (solid.inside) d = {-d.phi, -d.normal, d.slope};
    if (solid.moves) d.normal = to_world(solid, d.normal);
    return d;
  }
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
  return {far_away, {0, 0, 0}};
}

/// The shift to the distance τ (m) from a solid that is at `d` now: along the normal, and for a mesh by Newton's steps,
/// because its distance is interpolated.
KOKKOS_INLINE_FUNCTION Real3 to_distance(const Solid& solid, const Real3& x, Real3 shift, SolidDistance d,
                                         Real thickness) {
  shift += ((thickness - d.phi) / d.slope) * d.normal;
  for (int k = 0; solid.kind == 3 && k < 2; ++k) {
    d = solid_distance(solid, x, shift);
    if (d.phi < far_away) shift += ((thickness - d.phi) / d.slope) * d.normal;
  }
  return shift;
}

/// Moves x + shift out of all solids, in their order, to the distance τ (m) where it is nearer; returns the new shift.
template <class Solids>
KOKKOS_INLINE_FUNCTION Real3 project_out(const Solids& solids, const Real3& x, Real3 shift, Real thickness) {
  for (std::size_t b = 0; b < solids.extent(0); ++b) {
    const SolidDistance d = solid_distance(solids(b), x, shift);
    if (d.phi < thickness) shift = to_distance(solids(b), x, shift, d, thickness);
  }
  return shift;
}

/// v − n min(0, (v − v_s)·n): without the part that goes into a solid whose surface moves with v_s.
KOKKOS_INLINE_FUNCTION Real3 without_inward(const Real3& v, const Real3& normal, const Real3& surface) {
  const Real inward = dot(v - surface, normal);
  return inward < 0 ? v - inward * normal : v;
}

/// v − n min(0, v·n): without the part that goes into the solid.
KOKKOS_INLINE_FUNCTION Real3 without_inward(const Real3& v, const Real3& normal) {
  const Real inward = dot(v, normal);
  return inward < 0 ? v - inward * normal : v;
}

}  // namespace drench::kokkos_backend
