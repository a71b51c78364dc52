#pragma once
// Between the plain Vec3 of the shared structs and Eigen's vectors, for geometry code.

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "base/types.hpp"

namespace drench {

inline Eigen::Vector3d to_eigen(const Vec3& v) { return {v[0], v[1], v[2]}; }
inline Vec3 to_vec3(const Eigen::Vector3d& v) { return {v[0], v[1], v[2]}; }

inline bool contains(const Vec3& min, const Vec3& max, const Vec3& x) {
  for (int a = 0; a < 3; ++a) {
    if (!(x[a] >= min[a] && x[a] <= max[a])) return false;
  }
  return true;
}

}  // namespace drench
