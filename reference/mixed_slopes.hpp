#pragma once
// Slopes of distances that are interpolated on a lattice.

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cmath>

#include "state/body.hpp"

namespace drench::reference {

/// The slopes of a trilinear distance (m per cell) at w ∈ [0, 1]³ of a cell. Near the face between two cells the one
/// across it is mixed from both (docs/theory/cloth.md, Eq. (26e)). `own`: the slopes in the cell; value(i, j, k): the
/// distance at one of the points of `lattice`, m.
template <class Value>
Eigen::Vector3d mixed_slopes(const Eigen::Vector3d& own, const std::array<Index, 3>& cell, const Eigen::Vector3d& w,
                             const DistanceField& lattice, const Value& value) {
  constexpr double part = 0.1, wholly = 0.3;  // of the cell; of the lattice's spacing
  Eigen::Vector3d slopes = own;
  for (int a = 0; a < 3; ++a) {
    const double from_face = std::min(w[a], 1 - w[a]);
    const Index first = cell[a] + (w[a] < part ? -1 : 1);  // of the two planes around the other cell
    if (!(from_face < part) || first < 0 || first + 2 > lattice.points[a]) continue;
    double other = 0;
    for (int corner = 0; corner < 8; ++corner) {
      const std::array<int, 3> on{corner & 1, corner >> 1 & 1, corner >> 2};
      std::array<Index, 3> at = cell;
      at[a] = first;
      double weight = on[a] ? 1 : -1;
      for (int b = 0; b < 3; ++b) {
        at[b] += on[b];
        if (b != a) weight *= on[b] ? w[b] : 1 - w[b];
      }
      other += weight * value(at[0], at[1], at[2]);
    }
    const double jump = other - own[a], mixed = std::clamp(2 - std::abs(jump) / (wholly * lattice.spacing), 0.0, 1.0);
    slopes[a] += 0.5 * mixed * (1 - from_face / part) * jump;
  }
  return slopes;
}

}  // namespace drench::reference
