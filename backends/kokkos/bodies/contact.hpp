#pragma once
// Contact with the solid bodies, where they are at the end of the step. A mesh that is not closed has no distance: it
// acts through its samples only.

#include "bodies/bodies.hpp"
#include "bodies/nearest_point.hpp"

namespace drench::kokkos_backend {

/// Signed distance φ (m, positive on the free side), the unit normal towards the free side along its gradient, and how
/// fast φ grows along it: 1 but for a mesh's interpolated distance. T: the precision of the point.
template <class T = Real>
struct SolidDistance {
  T phi;
  Vector3<T> normal;
  T slope = 1;
};

/// Distance to a box: exact outside (Quilez), to the nearest face inside. `lo` = min − x and `hi` = x − max, m.
template <class T>
KOKKOS_INLINE_FUNCTION SolidDistance<T> box_distance(const Vector3<T>& lo, const Vector3<T>& hi) {
  const T low[3] = {lo.x, lo.y, lo.z}, high[3] = {hi.x, hi.y, hi.z};
  T beyond[3], side[3], normal[3] = {0, 0, 0}, square = 0;
  int axis = 0;
  for (int a = 0; a < 3; ++a) {
    side[a] = high[a] >= low[a] ? T(1) : T(-1);
    beyond[a] = high[a] >= low[a] ? high[a] : low[a];
    if (beyond[a] > beyond[axis]) axis = a;
    if (beyond[a] > 0) square += beyond[a] * beyond[a];
  }
  const T distance = Kokkos::sqrt(square);
  if (!(distance > 0)) {
    normal[axis] = side[axis];
    return {beyond[axis], {normal[0], normal[1], normal[2]}};
  }
  for (int a = 0; a < 3; ++a)
    if (beyond[a] > 0) normal[a] = side[a] * beyond[a] / distance;
  return {distance, {normal[0], normal[1], normal[2]}};
}

/// Slopes of distances are mixed in this part of a cell of the lattice from its faces, ...
template <class T>
constexpr T mixed_part = T(0.1);
/// ... wholly where they differ by at most this (1), less and less up to twice that, and not beyond.
template <class T>
constexpr T wholly_mixed = T(0.3);

constexpr Real far_away = Real(1e30);                   // m
constexpr Real no_part = Real(DistanceField::nowhere);  // m, beyond far_away: a part of a mesh is not there

/// The slopes of a trilinear distance (m per cell) at `w` of the cell that begins at `corner`. Along an axis they jump
/// from cell to cell; near the face between two cells the one across it is mixed from both (docs/theory/cloth.md,
/// Eq. 26e). `own`: the slopes in the cell; `wholly`: up to what difference they are mixed wholly, m per cell; first
/// and last: a bit of each axis, is the cell at the end of the lattice?
template <class T>
KOKKOS_FUNCTION DRENCH_SELDOM Vector3<T> mixed_slopes(const Real* corner, Index row, Index layer, Vector3<T> w,
                                                      Vector3<T> own, T wholly, unsigned first, unsigned last) {
  const T place[3] = {w.x, w.y, w.z};
  T slope[3] = {own.x, own.y, own.z};
  const Index steps[3] = {1, row, layer};
  for (int a = 0; a < 3; ++a) {
    const T from_face = smaller(place[a], 1 - place[a]);
    const bool before = place[a] < mixed_part<T>;
    if (!(from_face < mixed_part<T>) || ((before ? first : last) >> a & 1)) continue;
    const int b = (a + 1) % 3, c = (a + 2) % 3;
    const Real* const other = before ? corner - steps[a] : corner + steps[a];
    const auto change = [&](Index at) { return T(read_only(other + at + steps[a])) - T(read_only(other + at)); };
    const T low = change(0) + place[b] * (change(steps[b]) - change(0)),
            high = change(steps[c]) + place[b] * (change(steps[b] + steps[c]) - change(steps[c]));
    const T jump = low + place[c] * (high - low) - slope[a];
    const T mixed = smaller(T(1), larger(T(0), 2 - Kokkos::abs(jump) / wholly));
    slope[a] += T(0.5) * mixed * (1 - from_face / mixed_part<T>)*jump;
  }
  return {slope[0], slope[1], slope[2]};
}

/// Distance to a closed mesh from its field (trilinear), `x` relative to the centre in the body's own axes. Beyond the
/// lattice: far away.
template <class T>
KOKKOS_INLINE_FUNCTION SolidDistance<T> field_distance(const Solid& s, const Vector3<T>& x) {
  if (s.field == nullptr) return {far_away, {0, 0, 0}};
  const T inverse = 1 / T(s.field_spacing);
  const T at[3] = {inverse * (x.x - s.field_origin.x), inverse * (x.y - s.field_origin.y),
                   inverse * (x.z - s.field_origin.z)};
  Index cell[3];
  T w[3];
  unsigned at_first = 0, at_last = 0;  // a bit of each axis: the cell is the first or the last one
  bool near_face = false;
  for (int a = 0; a < 3; ++a) {
    const Index last = s.field_points[a] - 1;
    if (!(at[a] >= 0 && at[a] <= T(last))) return {far_away, {0, 0, 0}};
    cell[a] = static_cast<Index>(at[a]);
    if (cell[a] == last) --cell[a];
    w[a] = at[a] - T(cell[a]);
    at_first |= unsigned(cell[a] == 0) << a;
    at_last |= unsigned(cell[a] + 1 == last) << a;
    near_face = near_face || smaller(w[a], 1 - w[a]) < mixed_part<T>;
  }
  // Along x, then y, then z: the slopes are those of the same interpolation.
  const Index row = s.field_points[0], layer = row * s.field_points[1];
  const Real* const corner = s.field + (std::int64_t{cell[2]} * layer + (cell[1] * row + cell[0]));
  T value[2], of_x[2], of_y[2];
  for (int z = 0; z < 2; ++z) {
    T of_row[2], x_of_row[2];
    for (int y = 0; y < 2; ++y) {
      const T first = read_only(corner + z * layer + y * row);
      x_of_row[y] = T(read_only(corner + z * layer + y * row + 1)) - first;
      of_row[y] = first + w[0] * x_of_row[y];
    }
    of_y[z] = of_row[1] - of_row[0];
    value[z] = of_row[0] + w[1] * of_y[z];
    of_x[z] = x_of_row[0] + w[1] * (x_of_row[1] - x_of_row[0]);
  }
  const T of_z = value[1] - value[0], phi = value[0] + w[2] * of_z;
  Vector3<T> gradient{of_x[0] + w[2] * (of_x[1] - of_x[0]), of_y[0] + w[2] * (of_y[1] - of_y[0]), of_z};
  if (near_face)
    gradient = mixed_slopes(corner, row, layer, {w[0], w[1], w[2]}, gradient, wholly_mixed<T> * T(s.field_spacing),
                            at_first, at_last);
  const T length = norm(gradient);
  // At or next to points without a distance (Body::parts).
  if (!(phi < far_away && length < T(1e15))) return {no_part, {0, 0, 0}};
  if (!(length > 0)) return {phi, {0, 1, 0}};
  return {phi, (1 / length) * gradient, larger(inverse * length, T(0.5))};
}

/// The vector with the components of `own` along a moving solid's axes.
template <class T>
KOKKOS_INLINE_FUNCTION Vector3<T> to_world(const Solid& solid, const Vector3<T>& own) {
  return own.x * in_precision<T>(solid.axis[0]) + own.y * in_precision<T>(solid.axis[1]) +
         own.z * in_precision<T>(solid.axis[2]);
}
/// x + shift relative to the solid's centre, m.
template <class T>
KOKKOS_INLINE_FUNCTION Vector3<T> arm_of(const Solid& solid, const Real3& x, const Vector3<T>& shift) {
  return (in_precision<T>(x) - in_precision<T>(solid.center)) + shift;
}

/// Velocity (m/s) of the nearest point of a surface that changes its shape, from the triangle that the nearest lattice
/// point names; 0 beyond the band.
KOKKOS_INLINE_FUNCTION Real3 deforming_velocity(const Solid& s, const Real3& x) {
  const Real3 own = x - s.field_origin;
  const Real at[3] = {own.x / s.field_spacing, own.y / s.field_spacing, own.z / s.field_spacing};
  Index point[3];
  for (int a = 0; a < 3; ++a) {
    if (!(at[a] >= 0 && at[a] <= Real(s.field_points[a] - 1))) return {0, 0, 0};
    point[a] = static_cast<Index>(at[a] + Real(0.5));
  }
  const Index t =
      s.surface
          .nearest[(static_cast<std::int64_t>(point[2]) * s.field_points[1] + point[1]) * s.field_points[0] + point[0]];
  if (t < 0) return {0, 0, 0};
  const Index* const n = s.surface.corner + 3 * static_cast<std::int64_t>(t);
  const Real3* const p = s.surface.position;
  const Real3* const v = s.surface.velocity;
  const NearestPoint near = nearest_point(p[n[0]], p[n[1]], p[n[2]], own);
  return near.weight[0] * v[n[0]] + near.weight[1] * v[n[1]] + near.weight[2] * v[n[2]];
}

/// Velocity (m/s) of a solid's surface at x + shift.
template <class T>
KOKKOS_INLINE_FUNCTION Vector3<T> surface_velocity(const Solid& solid, const Real3& x, const Vector3<T>& shift) {
  if (!solid.moves) return {0, 0, 0};
  if (solid.surface.nearest != nullptr)
    return in_precision<T>(
        deforming_velocity(solid, (x - solid.center) + Real3{Real(shift.x), Real(shift.y), Real(shift.z)}));
  return in_precision<T>(solid.velocity) + cross(in_precision<T>(solid.spin), arm_of(solid, x, shift));
}

/// Distance of the point x + shift to a solid; the two are kept apart so that small shifts keep their digits in floats.
template <class T>
KOKKOS_INLINE_FUNCTION SolidDistance<T> solid_distance(const Solid& solid, const Real3& x, const Vector3<T>& shift) {
  if (solid.kind == 3 || (solid.kind == 0 && solid.moves)) {
    const Vector3<T> arm = arm_of(solid, x, shift);
    const Vector3<T> own =
        solid.moves ? Vector3<T>{dot(arm, in_precision<T>(solid.axis[0])), dot(arm, in_precision<T>(solid.axis[1])),
                                 dot(arm, in_precision<T>(solid.axis[2]))}
                    : arm;
    const Vector3<T> half = in_precision<T>(solid.half);
    SolidDistance<T> d = solid.kind == 3 ? field_distance(solid, own) : box_distance(-half - own, own - half);
    if (solid.inside) d = {-d.phi, -d.normal, d.slope};
    if (solid.moves) d.normal = to_world(solid, d.normal);
    return d;
  }
  const Vector3<T> at = in_precision<T>(x);
  if (solid.kind == 0) {
    SolidDistance<T> box =
        box_distance((in_precision<T>(solid.min) - at) - shift, (at - in_precision<T>(solid.max)) + shift);
    if (solid.inside) box = {-box.phi, -box.normal};
    return box;
  }
  if (solid.kind == 1) {
    const Vector3<T> out = arm_of(solid, x, shift);
    const T r = norm(out);
    return {r - solid.radius, r > 0 ? (1 / r) * out : Vector3<T>{0, 1, 0}};
  }
  if (solid.kind == 2) {
    const Vector3<T> normal = in_precision<T>(solid.normal);
    return {dot(at - in_precision<T>(solid.point), normal) + dot(shift, normal), normal};
  }
  return {far_away, {0, 0, 0}};
}

/// A point that leaves a mesh has arrived when its distance differs from the wanted one by at most this share. Newton's
/// method for cloth evaluates its residual in double precision and needs the smaller one.
template <class T>
constexpr T near_enough = sizeof(T) == sizeof(double) ? T(1e-9) : T(1e-4);

/// The shift to the distance τ (m) from a solid that is at `d` now: along the normal, and for a mesh, whose distance is
/// interpolated, by at most two more steps of Newton's method, until near_enough.
template <class T>
KOKKOS_INLINE_FUNCTION Vector3<T> to_distance(const Solid& solid, const Real3& x, Vector3<T> shift, SolidDistance<T> d,
                                              std::type_identity_t<T> thickness) {
  shift += ((thickness - d.phi) / d.slope) * d.normal;
  DRENCH_ROLLED
  for (int k = 0; solid.kind == 3 && k < 2; ++k) {
    d = solid_distance(solid, x, shift);
    const T off = thickness - d.phi;
    if (!(d.phi < far_away) || Kokkos::abs(off) <= near_enough<T> * thickness) return shift;
    shift += (off / d.slope) * d.normal;
  }
  return shift;
}

/// How far a node of the cloth has to stay from solids: its thickness, or less from one that it has begun the step
/// inside of (near_solid).
struct Clearance {
  Real thickness;  // m
  Real least;      // m: the least of all solids (Nodes::clearance)
  Real release;    // m: how far it comes out of a solid in the step at most
  Real dt;         // s
};

/// The distance (m) of a node from one of the solids where both begin the step, the node at x. Solids are at the end of
/// the step: the node's place relative to where they were is that far ahead.
KOKKOS_FUNCTION DRENCH_SELDOM inline Real distance_at_start(const Solid& solid, const Real3& x, Real dt) {
  return solid_distance(solid, x, dt * surface_velocity(solid, x, Real3{})).phi;
}
/// The distance (m) that a node keeps from a solid that is `start` (m) away from it as the step begins.
KOKKOS_INLINE_FUNCTION Real kept_from(Real start, const Clearance& clearance) {
  return smaller(clearance.thickness, start + clearance.release);
}
/// Clearance::least of a node that begins the step at x.
template <class Solids>
KOKKOS_INLINE_FUNCTION Real least_kept(const Solids& solids, const Real3& x, const Clearance& clearance) {
  Real least = clearance.thickness;
  for (std::size_t b = 0; b < solids.extent(0); ++b) {
    const Real start = distance_at_start(solids(static_cast<std::int64_t>(b)), x, clearance.dt);
    least = smaller(least, kept_from(start, clearance));
  }
  return least;
}

/// A solid next to a point: how far it is, and how far the cloth keeps from it alone, m.
template <class T>
struct NearSolid {
  SolidDistance<T> at;
  Real kept;
  bool plane = false;  // a plane stands for it: near_solid
};
/// near_solid for a node that keeps less than its thickness from one of the solids.
template <class T>
KOKKOS_FUNCTION DRENCH_SELDOM NearSolid<T> near_solid_inside(const Solid& solid, const Real3& x,
                                                             const Vector3<T>& shift, const Clearance& clearance) {
  const Vector3<T> moved = T(clearance.dt) * in_precision<T>(surface_velocity(solid, x, Real3{}));
  const SolidDistance<T> start = solid_distance(solid, x, moved);
  if (!(start.phi < no_part)) return {start, -far_away};
  const Real kept = kept_from(Real(start.phi), clearance);
  if (!(start.phi < 0 && kept < Real(0.999) * clearance.thickness)) return {solid_distance(solid, x, shift), kept};
  return {{start.phi + dot(start.normal, shift - moved), start.normal}, kept, true};
}
/// A solid as a node at x + shift sees it that begins the step at x. Inside a solid the distance has kinks, and
/// iterations would alternate between their sides. For a node that begins the step there, a plane stands for the solid
/// (docs/theory/cloth.md, Eq. 26d). A part of a mesh that is absent at the start (no_part) does not hold it.
template <class T>
KOKKOS_INLINE_FUNCTION NearSolid<T> near_solid(const Solid& solid, const Real3& x, const Vector3<T>& shift,
                                               const Clearance& clearance) {
  if (clearance.least < clearance.thickness) return near_solid_inside(solid, x, shift, clearance);
  return {solid_distance(solid, x, shift), clearance.thickness};
}
/// to_distance, for a node from a solid next to it.
template <class T>
KOKKOS_INLINE_FUNCTION Vector3<T> to_distance(const Solid& solid, const Real3& x, const Vector3<T>& shift,
                                              const NearSolid<T>& own, std::type_identity_t<T> distance) {
  if (own.plane) return shift + (distance - own.at.phi) * own.at.normal;
  return to_distance(solid, x, shift, own.at, distance);
}

constexpr Real same_direction = Real(0.9);  // cosine: surfaces with such normals do not face each other
/// Are they parts of one mesh that have nearly the same surface there? Then one alone counts.
template <class T>
KOKKOS_INLINE_FUNCTION bool alike(const Solid& one, const Vector3<T>& normal, const Solid& other,
                                  const Vector3<T>& other_normal) {
  return one.body == other.body && dot(normal, other_normal) > T(same_direction);
}

/// Do two solids squeeze the point x + shift? They do where they face each other and leave the cloth no room on both
/// sides, and at the mouth of such a gap.
template <class T>
KOKKOS_INLINE_FUNCTION bool squeezed(const Solid& one, const NearSolid<T>& a, const Solid& other, const NearSolid<T>& b,
                                     const Real3& x, const Vector3<T>& shift, Real thickness) {
  constexpr T opposed = T(-0.5), depth = T(1.5);  // a cosine; of the thickness
  if (!(a.at.phi + b.at.phi < a.kept + b.kept)) return false;
  const T cosine = dot(a.at.normal, b.at.normal);
  if (cosine < 0 || cosine > T(same_direction)) return cosine < 0;
  const Vector3<T> out = a.at.normal + b.at.normal, inside = shift - (depth * thickness / norm(out)) * out;
  return dot(solid_distance(one, x, inside).normal, solid_distance(other, x, inside).normal) < opposed;
}

/// The width, over that of the free cloth, at which two solids begin to squeeze a node: 1, or less where it comes out
/// of one of them (docs/theory/cloth.md, Eq. 26a).
template <class T>
KOKKOS_INLINE_FUNCTION T unsqueezed_width(const NearSolid<T>& a, const NearSolid<T>& b,
                                          std::type_identity_t<T> thickness) {
  const auto own = [&](const NearSolid<T>& near) { return near.plane ? T(near.kept) : thickness; };
  return (own(a) + own(b)) / (2 * thickness);
}

/// The surface halfway between what two solids that squeeze a node keep free: its unit normal, away from the first, and
/// how far the node is beyond it along that normal (m).
template <class T>
struct Halfway {
  Vector3<T> normal;
  T beyond;

  KOKKOS_INLINE_FUNCTION Halfway(const NearSolid<T>& one, const NearSolid<T>& other) {
    const Vector3<T> gradient = one.at.slope * one.at.normal - other.at.slope * other.at.normal;
    const T inverse = 1 / norm(gradient);
    normal = inverse * gradient;
    beyond = inverse * ((one.at.phi - other.at.phi) - (one.kept - other.kept));
  }
};

/// The distance (m) that a point keeps from solid b beside others (distance_to_keep).
template <class T, class Solids>
KOKKOS_FUNCTION DRENCH_SELDOM T distance_to_keep_of_several(const Solids& solids, std::size_t b,
                                                            const NearSolid<T>& own, const Real3& x,
                                                            const Vector3<T>& shift, const Clearance& clearance) {
  T kept = own.kept;
  for (std::size_t a = 0; a < solids.extent(0); ++a) {
    if (a == b) continue;
    const Solid &one = solids(static_cast<std::int64_t>(a)), &solid = solids(static_cast<std::int64_t>(b));
    const NearSolid<T> other = near_solid(one, x, shift, clearance);
    if (squeezed(one, other, solid, own, x, shift, clearance.thickness))
      kept = smaller(kept, T(0.5) * ((other.at.phi + own.at.phi) + (own.kept - other.kept)));
  }
  return kept;
}
/// The distance (m) that a point keeps from solid b: what it keeps from that alone, or its share of the gap where
/// another solid faces b too closely (docs/theory/cloth.md, section 11).
template <class T, class Solids>
KOKKOS_INLINE_FUNCTION T distance_to_keep(const Solids& solids, std::size_t b, const NearSolid<T>& own, const Real3& x,
                                          const Vector3<T>& shift, const Clearance& clearance) {
  if (solids.extent(0) == 1) return own.kept;
  return distance_to_keep_of_several(solids, b, own, x, shift, clearance);
}

/// Does solid b, at the distance `own` from x + shift, pull on wet cloth there? Of two parts of one mesh that do not
/// face each other only the nearer one does.
template <class Solids>
KOKKOS_INLINE_FUNCTION bool sticks_by_itself(const Solids& solids, std::size_t b, const SolidDistance<>& own,
                                             const Real3& x, const Real3& shift) {
  for (std::size_t a = 0; a < solids.extent(0); ++a) {
    if (a == b || solids(a).body != solids(b).body) continue;
    const SolidDistance<> other = solid_distance(solids(a), x, shift);
    const bool nearer = other.phi < own.phi || (other.phi == own.phi && a < b);
    if (nearer && dot(other.normal, own.normal) > 0) return false;
  }
  return true;
}

/// Moves x + shift out of all solids, in their order, to the distance that it keeps from them; returns the new shift.
template <class T, class Solids>
KOKKOS_INLINE_FUNCTION Vector3<T> project_out(const Solids& solids, const Real3& x, Vector3<T> shift,
                                              const Clearance& clearance) {
  for (std::size_t b = 0; b < solids.extent(0); ++b) {
    const Solid& solid = solids(static_cast<std::int64_t>(b));
    const NearSolid<T> own = near_solid(solid, x, shift, clearance);
    if (!(own.at.phi < own.kept)) continue;
    const T kept = distance_to_keep(solids, b, own, x, shift, clearance);
    if (own.at.phi < kept) shift = to_distance(solid, x, shift, own, kept);
  }
  return shift;
}

constexpr Real grazing = Real(0.25);  // spacings: how deep a path may be in a solid that it only grazes

/// Does the way from `start` to x (m) enter a solid, more than grazing it? Then x becomes where a particle gets along
/// the surface from there. `spacing` (m): of the liquid. Law 4 of docs/theory/contacts.md.
KOKKOS_FUNCTION DRENCH_SELDOM inline bool stop_at_entry(const Solid& solid, const Real3& start, Real spacing,
                                                        Real3& x) {
  const Real3 way = x - start;
  constexpr int most = 64, halvings = 8;
  const auto at = [&](Real share) { return solid_distance(solid, start, share * way); };
  const Real deep = grazing * spacing;
  if (!(at(0).phi > -deep)) return false;
  const int parts = static_cast<int>(smaller(Real(most), 1 + norm(way) / deep));
  Real outside = 0, inside = 0;
  for (int k = 1; k <= parts; ++k) {
    inside = Real(k) / Real(parts);
    const Real phi = at(inside).phi;
    if (phi < -deep) break;
    if (k == parts) return false;
    if (phi >= 0) outside = inside;
  }
  for (int k = 0; k < halvings; ++k) {
    const Real middle = Real(0.5) * (outside + inside);
    (at(middle).phi < 0 ? inside : outside) = middle;
  }
  const Real3 left = (1 - outside) * way, normal = at(outside).normal,
              along = outside * way + (left - dot(left, normal) * normal);
  x = start + (solid_distance(solid, start, along).phi > -deep ? along : outside * way);
  return true;
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
