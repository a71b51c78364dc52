#pragma once
// Rigid bodies: poses in double, whatever the precision of the particles; laws in src/stages/bodies.hpp.

#include "core/double3.hpp"

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

/// A hinge that leaves a dynamic body one turn, about an axis of the world or of a body that is not dynamic. Its
/// vectors are those of t = 0.
struct Hinge {
  int present;
  Index other;           // −1: the world
  Double3 arm, axis;     // from the body's centre to the axis, m; unit
  Double3 mark;          // unit, at right angles to the axis: what the angle is measured by
  double middle, half;   // rad: between its stops, and how far they are from there
  double speed, torque;  // rad/s, N m: of the motor in this step; no torque: no motor
};

/// The velocities that the hinge, its motor and its stops leave a body after `dt` (docs/theory/bodies.md, (5b)).
/// `other`: null for the world.
KOKKOS_INLINE_FUNCTION void hold_by_hinge(const Hinge& h, const RigidBody& body, const RigidState& s,
                                          const RigidState* other, double dt, Double3& velocity, Double3& spin) {
  constexpr double pi = 3.14159265358979323846;
  const Double3 a = rotate(s.orientation, h.axis), arm = rotate(s.orientation, h.arm);
  const Double3 lever = outer(arm, a);  // of the centre, for each rad/s
  Double3 carried, turned;              // what the other's motion gives the body
  Double3 mark = h.mark;
  if (other) {
    turned = other->spin;
    carried = add(other->velocity, outer(turned, minus(s.position, other->position)));
    mark = rotate(other->orientation, mark);
  }
  const Double3 own = rotate(s.orientation, h.mark);
  const double angle = Kokkos::atan2(inner(a, outer(mark, own)), inner(mark, own));
  const double mass = 1 / body.inverse_mass;
  const double inertia = inner(a, times_inertia(body, s.orientation, a)) + mass * inner(lever, lever);
  const double momentum =
      inner(a, times_inertia(body, s.orientation, minus(spin, turned))) + mass * inner(lever, minus(velocity, carried));
  double rate = momentum / inertia;
  if (h.torque > 0) {
    const double most = h.torque * dt / inertia;
    rate += larger(-most, smaller(most, h.speed - rate));
  }
  double off = angle - h.middle;
  if (off > pi) off -= 2 * pi;
  if (off < -pi) off += 2 * pi;
  if (off + rate * dt < -h.half) rate = larger(0.0, rate);
  if (off + rate * dt > h.half) rate = smaller(0.0, rate);
  velocity = add(carried, times(rate, lever));
  spin = add(turned, times(rate, a));
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
