#pragma once

#include <algorithm>
#include <cmath>

#include "state/model.hpp"

namespace drench {

/// Liquid outside is removed. A little larger than the domain, so that liquid at a wall on the domain's border stays,
/// however its position is rounded: by a thousandth of a spacing, at least a millionth of the farthest coordinate.
inline Box domain_border(const Model& m) {
  Box border = m.scene.domain;
  double farthest = 0;
  for (std::size_t a = 0; a < 3; ++a) farthest = std::max({farthest, std::abs(border.min[a]), std::abs(border.max[a])});
  const double slack = std::max(1e-3 * m.spacing, 1e-6 * farthest);
  for (std::size_t a = 0; a < 3; ++a) {
    border.min[a] -= slack;
    border.max[a] += slack;
  }
  return border;
}

}  // namespace drench
