#pragma once
// Between the plain Vec3 of the shared structs and Eigen's vectors, for geometry code.

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cmath>

#include "base/types.hpp"

namespace drench {

inline Eigen::Vector3d to_eigen(const Vec3& v) { return {v[0], v[1], v[2]}; }
inline Vec3 to_vec3(const Eigen::Vector3d& v) { return {v[0], v[1], v[2]}; }

/// The shortest rotation from one direction to another; between opposite ones half a turn about some axis across them.
/// Eigen's own takes a singular value decomposition for that case, which costs every file that calls it 15 s to
/// compile.
inline Eigen::Quaterniond shortest_turn(const Eigen::Vector3d& from, const Eigen::Vector3d& to) {
  const Eigen::Vector3d a = from.normalized(), b = to.normalized();
  const double cosine = a.dot(b);
  Eigen::Quaterniond turn;
  if (cosine > -1 + 1e-12) {
    const double s = std::sqrt(2 * (1 + cosine));
    turn.w() = 0.5 * s;
    turn.vec() = a.cross(b) / s;
  } else {
    turn.w() = 0;
    turn.vec() = a.unitOrthogonal();
  }
  return turn;
}

inline bool contains(const Vec3& min, const Vec3& max, const Vec3& x) {
  for (int a = 0; a < 3; ++a) {
    if (!(x[a] >= min[a] && x[a] <= max[a])) return false;
  }
  return true;
}

}  // namespace drench
