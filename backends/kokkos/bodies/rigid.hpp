#pragma once
// Rigid bodies: poses in double, whatever the precision of the particles; laws in src/stages/bodies.hpp.

#include "core/double3.hpp"
#include "state/rigid_contacts.hpp"

namespace drench::kokkos_backend {

/// A rotation, of length 1.
struct Quaternion {
  double w = 1, x = 0, y = 0, z = 0;
};

inline Double3 to_double(const Vec3& a) { return {a[0], a[1], a[2]}; }
inline Vec3 plain(const Double3& a) { return {a.x, a.y, a.z}; }

/// v rotate by q.
KOKKOS_INLINE_FUNCTION Double3 rotate(const Quaternion& q, const Double3& v) {
  const Double3 u{q.x, q.y, q.z};
  const Double3 t = times(2, outer(u, v));
  return add(v, add(times(q.w, t), outer(u, t)));
}
KOKKOS_INLINE_FUNCTION Double3 rotate_back(const Quaternion& q, const Double3& v) {
  return rotate({q.w, -q.x, -q.y, -q.z}, v);
}
/// The rotation by the vector `angle` (rad).
KOKKOS_INLINE_FUNCTION Quaternion rotation_by(const Double3& angle) {
  const double a = Kokkos::sqrt(inner(angle, angle));
  if (!(a > 0)) return {};
  const double s = Kokkos::sin(0.5 * a) / a;
  return {Kokkos::cos(0.5 * a), s * angle.x, s * angle.y, s * angle.z};
}
/// First b, then a; of length 1 again.
KOKKOS_INLINE_FUNCTION Quaternion multiply(const Quaternion& a, const Quaternion& b) {
  const Quaternion q{a.w * b.w - a.x * b.x - a.y * b.y - a.z * b.z, a.w * b.x + a.x * b.w + a.y * b.z - a.z * b.y,
                     a.w * b.y - a.x * b.z + a.y * b.w + a.z * b.x, a.w * b.z + a.x * b.y - a.y * b.x + a.z * b.w};
  const double length = Kokkos::sqrt(q.w * q.w + q.x * q.x + q.y * q.y + q.z * q.z);
  return {q.w / length, q.x / length, q.y / length, q.z / length};
}

/// A body where it is: m, m/s, rad/s.
struct RigidState {
  Double3 position, velocity, spin;
  Quaternion orientation;
};

inline RigidMotion motion_of(const RigidState& s) {
  return {plain(s.position),
          plain(s.velocity),
          plain(s.spin),
          {s.orientation.w, s.orientation.x, s.orientation.y, s.orientation.z}};
}
inline RigidState state_of(const RigidMotion& m) {
  return {to_double(m.position),
          to_double(m.velocity),
          to_double(m.spin),
          {m.orientation[0], m.orientation[1], m.orientation[2], m.orientation[3]}};
}

/// What stays the same of a body.
struct RigidBody {
  int kind, moves, dynamic, slides, keyed;  // keyed: its motion changes with time by prescription
  int measured;                             // what acts on it is added up: it is dynamic, or a program moves it
  Double3 rest_center;                      // m
  Double3 rest_velocity, rest_spin;         // m/s, rad/s: the prescribed ones
  double inverse_mass;                      // 1/kg; 0 unless dynamic
  Double3 inertia, inverse_inertia;         // kg m², about the principal axes; 0 unless dynamic
  Quaternion principal;                     // turns the axes of t = 0 to the principal ones
  Double3 half;                             // m: a box's half edges
  double radius;                            // m: a sphere's
  double reach;                             // m
  Double3 lattice[2], middle;               // m: of a plane that moves
  Index first_sample, sample_count;         // among all boundary samples
  Index first_dynamic;                      // among those of the measured bodies
};

/// The pose after dt of steady motion.
KOKKOS_INLINE_FUNCTION RigidState moved(const RigidState& s, double dt) {
  RigidState end = s;
  end.position = add(s.position, times(dt, s.velocity));
  end.orientation = multiply(rotation_by(times(dt, s.spin)), s.orientation);
  return end;
}

/// I⁻¹ v in the world's axes.
KOKKOS_INLINE_FUNCTION Double3 over_inertia(const RigidBody& body, const Quaternion& q, const Double3& v) {
  const Double3 own = rotate_back(body.principal, rotate_back(q, v));
  const Double3& i = body.inverse_inertia;
  return rotate(q, rotate(body.principal, {i.x * own.x, i.y * own.y, i.z * own.z}));
}
/// I v in the world's axes.
KOKKOS_INLINE_FUNCTION Double3 times_inertia(const RigidBody& body, const Quaternion& q, const Double3& v) {
  const Double3 own = rotate_back(body.principal, rotate_back(q, v));
  const Double3& i = body.inertia;
  return rotate(q, rotate(body.principal, {i.x * own.x, i.y * own.y, i.z * own.z}));
}

/// Force (N) and torque about the centre (N m).
struct Wrench {
  Double3 force, torque;
  KOKKOS_INLINE_FUNCTION Wrench& operator+=(const Wrench& o) {
    force = add(force, o.force);
    torque = add(torque, o.torque);
    return *this;
  }
};

}  // namespace drench::kokkos_backend
