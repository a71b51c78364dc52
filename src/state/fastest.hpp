#pragma once
// The largest speed of some velocities.

#include <algorithm>
#include <cmath>
#include <vector>

#include "base/types.hpp"

namespace drench {

/// m/s; 0 of none.
inline double fastest_of(const std::vector<Vec3>& velocities) {
  double fastest = 0;
  for (const Vec3& v : velocities) fastest = std::max(fastest, std::hypot(v[0], v[1], v[2]));
  return fastest;
}

}  // namespace drench
