#include "neighbor_search.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <tuple>

namespace drench::reference {

using Eigen::Vector3d;

Vectors vectors(const std::vector<Vec3>& points) {
  Vectors result;
  for (const Vec3& x : points) result.push_back(vec(x));
  return result;
}

SortedCells::SortedCells(const Vectors& points, double support, const std::vector<std::int64_t>& key)
    : points_(points), support_(support), origin_(Vector3d::Constant(std::numeric_limits<double>::infinity())) {
  for (const Vector3d& x : points_) {
    if (x.allFinite()) origin_ = origin_.cwiseMin(x);
  }
  for (Index p = 0; p < static_cast<Index>(points_.size()); ++p) {
    if (points_[p].allFinite()) entries_.push_back({cell_of(points_[p]), key.empty() ? p : key[p], p});
  }
  std::ranges::sort(entries_, [](const Entry& a, const Entry& b) {
    return std::tie(a.cell, a.key, a.point) < std::tie(b.cell, b.key, b.point);
  });
}

std::array<std::int64_t, 3> SortedCells::cell_of(const Vector3d& x) const {
  constexpr double farthest = 1e15;  // still exact as an integer; what lies farther shares the last cell
  const auto along = [&](int axis) {
    return static_cast<std::int64_t>(std::clamp(std::floor((x[axis] - origin_[axis]) / support_), -farthest, farthest));
  };
  return {along(2), along(1), along(0)};
}

NeighborLists SortedCells::around(const Vectors& rows, bool same_set) const {
  NeighborLists lists(rows.size());
  if (entries_.empty()) return lists;
  // A little more than h, so that rounding at a cell's face loses no neighbour.
  const Vector3d reach = Vector3d::Constant(support_ * (1 + 1e-9));
  for (Index row = 0; row < static_cast<Index>(rows.size()); ++row) {
    const Vector3d& x = rows[row];
    if (!x.allFinite()) continue;
    const auto low = cell_of(x - reach), high = cell_of(x + reach);
    for (std::int64_t z = low[0]; z <= high[0]; ++z) {
      for (std::int64_t y = low[1]; y <= high[1]; ++y) {
        const std::array<std::int64_t, 3> first{z, y, low[2]}, last{z, y, high[2]};
        for (auto e = std::ranges::lower_bound(entries_, first, {}, &Entry::cell);
             e != entries_.end() && e->cell <= last; ++e) {
          const Vector3d& other = points_[e->point];
          const double dx = x[0] - other[0], dy = x[1] - other[1], dz = x[2] - other[2];
          if (dx * dx + dy * dy + dz * dz >= support_ * support_) continue;
          if (same_set && e->point == row) continue;
          lists[row].push_back(e->point);
        }
      }
    }
  }
  return lists;
}

}  // namespace drench::reference
