#include "proximity.hpp"

#include <algorithm>
#include <vector>

#include "collision.hpp"

namespace drench::reference {

using Eigen::Vector3d;

namespace {

/// Where along a b lies the point nearest to p: 0 to 1.
double along(const Vector3d& p, const Vector3d& a, const Vector3d& b) {
  const double length = (b - a).squaredNorm();
  return length > 0 ? std::clamp((p - a).dot(b - a) / length, 0.0, 1.0) : 0;
}

}  // namespace

Near near_triangle(const Four& x) {
  // The foot point if it lies inside, else the nearest point of the three edges.
  const std::optional<Vector3d> w = barycentric({x[1], x[2], x[3]}, x[0]);
  if (w && w->minCoeff() >= 0) {
    return {{1, -(*w)[0], -(*w)[1], -(*w)[2]}, x[0] - (*w)[0] * x[1] - (*w)[1] * x[2] - (*w)[2] * x[3]};
  }
  Near best{{}, Vector3d::Constant(1e300)};
  for (int k = 0; k < 3; ++k) {
    const int a = 1 + k, b = 1 + (k + 1) % 3;
    const double s = along(x[0], x[a], x[b]);
    const Vector3d apart = x[0] - x[a] - s * (x[b] - x[a]);
    if (!(apart.squaredNorm() < best.apart.squaredNorm())) continue;
    best = {{1, 0, 0, 0}, apart};
    best.b[a] = s - 1;
    best.b[b] = -s;
  }
  return best;
}

Near near_edges(const Four& x) {
  const Vector3d p = x[1] - x[0], q = x[3] - x[2], r = x[2] - x[0];
  // Inside both edges where the lines' nearest points are, else one of them is an end.
  const double pp = p.squaredNorm(), qq = q.squaredNorm(), pq = p.dot(q), det = pp * qq - pq * pq;
  std::vector<std::array<double, 2>> trials;
  if (det > 1e-14 * pp * qq) {
    const double s = (qq * p.dot(r) - pq * q.dot(r)) / det, t = (pq * p.dot(r) - pp * q.dot(r)) / det;
    if (s >= 0 && s <= 1 && t >= 0 && t <= 1) trials.push_back({s, t});
  }
  if (trials.empty()) {
    trials = {{0, along(x[0], x[2], x[3])},
              {1, along(x[1], x[2], x[3])},
              {along(x[2], x[0], x[1]), 0},
              {along(x[3], x[0], x[1]), 1}};
  }
  Near best{{}, Vector3d::Constant(1e300)};
  for (const auto& [s, t] : trials) {
    const Vector3d apart = -r + s * p - t * q;
    if (apart.squaredNorm() < best.apart.squaredNorm()) best = {{1 - s, s, t - 1, -t}, apart};
  }
  return best;
}

}  // namespace drench::reference
