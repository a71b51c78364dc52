#pragma once
// Prescribed motion that changes with time: where bodies are by their keys, and how fast keys let anything be.

#include <array>

#include "state/model.hpp"

namespace drench {

/// How far the centre of a body has come by `time` (s) by its velocity and its path, m.
Vec3 way_at(const Body& body, double time);
/// The velocity of its centre, m/s; at a corner of the path, that after it.
Vec3 velocity_at(const Body& body, double time);
/// How it has turned since t = 0.
Quaternion orientation_at(const Body& body, double time);
/// Its angular velocity between two times, rad/s: steady, it turns the body as its keys do. At the first of them if
/// both are one.
Vec3 spin_between(const Body& body, double from, double to);
/// Where the body brings a point that is at `arm` (m) from its centre at t = 0, and at `time` (s), m.
Vec3 carried_point(const Body& body, const Vec3& arm, double time);
/// That arm of a point that is at x (m) at `time`.
Vec3 arm_of_point(const Body& body, const Vec3& x, double time);
/// The fastest that it turns between two times, rad/s.
double fastest_turn(const Body& body, double from, double to);
/// The least and the most of way_at along each axis until `duration`, s; what lies between may be less.
std::array<Vec3, 2> bounds_of_way(const Body& body, double duration);

/// m/s: the fastest that keys let a body, a pin or a jet be between two times (s); 0 without keys.
double fastest_by_keys(const Model& model, double from, double to);

}  // namespace drench
