#include "setup/mesh_moments.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <map>

#include "base/eigen_vec.hpp"
#include "base/sets.hpp"
#include "setup/surface_distance.hpp"

namespace drench {
namespace {

using Eigen::Vector3d;
using Triangles = std::vector<std::array<Index, 3>>;

/// Integrals of 1, x and x xᵀ, with x seen from an origin.
struct Sums {
  double volume = 0;
  Vector3d first = Vector3d::Zero();
  Eigen::Matrix3d second = Eigen::Matrix3d::Zero();
};

/// Boxes around the parts of a mesh that have no point in common.
std::vector<Eigen::AlignedBox3d> boxes_of_parts(const std::vector<Vec3>& points, const Triangles& triangles) {
  Sets joined(points.size());
  for (const auto& t : triangles)
    for (const Index i : t) joined.unite(i, t[0]);
  std::map<Index, Eigen::AlignedBox3d> boxes;
  for (const auto& t : triangles)
    for (const Index i : t) boxes[joined.root(i)].extend(to_eigen(points[at(i)]));
  std::vector<Eigen::AlignedBox3d> list;
  for (const auto& [first, box] : boxes) list.push_back(box);
  return list;
}

/// Borders of cells along an axis. The bounds of the parts are among them, so that boxes along the axes are exact.
std::vector<double> borders(const std::vector<Eigen::AlignedBox3d>& parts, int axis) {
  constexpr double lines = 300;
  std::vector<double> bounds, cells;
  for (const auto& box : parts) {
    bounds.push_back(box.min()[axis]);
    bounds.push_back(box.max()[axis]);
  }
  std::sort(bounds.begin(), bounds.end());
  const double size = bounds.back() - bounds.front();
  cells.push_back(bounds.front());
  for (const double bound : bounds) {
    const double from = cells.back(), gap = bound - from;
    if (!(gap > 0) || (bound < bounds.back() && gap < 0.25 * size / lines)) continue;
    const int count = static_cast<int>(std::ceil(lines * gap / size));
    for (int k = 1; k <= count; ++k) cells.push_back(k == count ? bound : from + gap * k / count);
  }
  return cells;
}

/// What the triangles count too often, as a multiple for a winding number of 2 or more, or less than 0.
Sums overlap(const std::vector<Vec3>& points, const Triangles& triangles, const Vector3d& origin) {
  Sums sum;
  if (triangles.empty()) return sum;
  const std::vector<Eigen::AlignedBox3d> parts = boxes_of_parts(points, triangles);
  double size = 0;
  for (const auto& box : parts) size = std::max(size, box.sizes().maxCoeff());
  const double rounding = 1e-9 * size;  // m: surfaces that touch
  const WindingNumber winding(points, triangles);
  std::vector<WindingNumber::Crossing> met;
  const std::vector<double> ys = borders(parts, 1), zs = borders(parts, 2);
  for (std::size_t j = 0; j + 1 < ys.size(); ++j)
    for (std::size_t k = 0; k + 1 < zs.size(); ++k) {
      const double y = 0.5 * (ys[j] + ys[j + 1]), z = 0.5 * (zs[k] + zs[k + 1]), dy = ys[j + 1] - ys[j],
                   dz = zs[k + 1] - zs[k];
      winding.crossings(y, z, met);
      int around = 0;
      for (std::size_t c = 0; c + 1 < met.size(); ++c) {
        around += met[c].change;
        const double length = met[c].x - met[c + 1].x;
        const int extra = around - (around >= 1 ? 1 : 0);
        if (extra == 0 || length <= rounding) continue;
        const double volume = extra * dy * dz * length;
        const Vector3d middle = Vector3d(0.5 * (met[c].x + met[c + 1].x), y, z) - origin;
        sum.volume += volume;
        sum.first += volume * middle;
        sum.second += volume * (middle * middle.transpose());
        sum.second.diagonal() += volume / 12 * Vector3d(length * length, dy * dy, dz * dz);
      }
    }
  return sum;
}

}  // namespace

MeshMoments moments_of(const std::vector<Vec3>& points, const Triangles& triangles, const Vec3& near) {
  const Vector3d origin = to_eigen(near);
  MeshMoments sum;
  Vector3d first = Vector3d::Zero();
  for (const auto& t : triangles) {  // tetrahedra to the origin
    Eigen::Matrix3d x;
    for (int k = 0; k < 3; ++k) x.col(k) = to_eigen(points[at(t[static_cast<std::size_t>(k)])]) - origin;
    const double volume = x.determinant() / 6;
    const Vector3d corners = x.rowwise().sum();
    sum.volume += volume;
    first += volume / 4 * corners;
    sum.second += volume / 20 * (x * x.transpose() + corners * corners.transpose());
  }
  const Sums extra = overlap(points, triangles, origin);
  sum.volume -= extra.volume;
  first -= extra.first;
  sum.second -= extra.second;
  const Vector3d middle = first / sum.volume;
  sum.second -= sum.volume * middle * middle.transpose();
  sum.center = origin + middle;
  return sum;
}

}  // namespace drench
