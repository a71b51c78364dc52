#include "setup/point_grid.hpp"

#include "setup/smoothing_kernel.hpp"

namespace drench {
namespace {

double distance_squared(const Vec3& a, const Vec3& b) {
  const double x = a[0] - b[0], y = a[1] - b[1], z = a[2] - b[2];
  return x * x + y * y + z * z;
}

}  // namespace

std::size_t PointGrid::Hash::operator()(const Cell& c) const {
  std::uint64_t h = 0;
  for (const std::int64_t v : c) {
    h = (h ^ static_cast<std::uint64_t>(v)) * 0x9e3779b97f4a7c15ull;
    h ^= h >> 29;
  }
  return static_cast<std::size_t>(h);
}

bool PointGrid::any_within(const Vec3& x, double distance) const {
  bool found = false;
  const Vec3 lo{x[0] - distance, x[1] - distance, x[2] - distance};
  const Vec3 hi{x[0] + distance, x[1] + distance, x[2] + distance};
  for_box(lo, hi, [&](Index p) {
    if (distance_squared(points_[static_cast<std::size_t>(p)], x) < distance * distance) found = true;
  });
  return found;
}

double layer_share(double spacing, double support, KernelKind kernel) {
  const int reach = static_cast<int>(support / spacing) + 1;
  double share = 0;
  for (int a = -reach; a <= reach; ++a) {
    for (int b = -reach; b <= reach; ++b) {
      share += spacing * spacing * spacing * kernel_value(kernel, spacing * std::hypot(a, b), support);
    }
  }
  return share;
}

std::vector<double> akinci_volumes(const std::vector<Vec3>& points, double support, KernelKind kernel) {
  PointGrid grid(support);
  for (const Vec3& x : points) grid.add(x);
  std::vector<double> volume(points.size());
  std::vector<Index> near;
  // Cell by cell, so that the 27 look-ups are shared by all points of a cell. The order within each sum depends
  // only on the geometry and the points' order, never on the hash.
  for (const auto& [cell, members] : grid.cells_) {
    near.clear();
    for (int i = -1; i <= 1; ++i) {
      for (int j = -1; j <= 1; ++j) {
        for (int k = -1; k <= 1; ++k) {
          const auto found = grid.cells_.find({cell[0] + i, cell[1] + j, cell[2] + k});
          if (found != grid.cells_.end()) near.insert(near.end(), found->second.begin(), found->second.end());
        }
      }
    }
    for (const Index p : members) {
      const Vec3& x = points[static_cast<std::size_t>(p)];
      double sum = 0;
      for (const Index k : near) {
        const double r2 = distance_squared(x, points[static_cast<std::size_t>(k)]);
        if (r2 < support * support) sum += kernel_value(kernel, std::sqrt(r2), support);
      }
      volume[static_cast<std::size_t>(p)] = 1 / sum;
    }
  }
  return volume;
}

}  // namespace drench
