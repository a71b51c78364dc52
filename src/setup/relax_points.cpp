#include "setup/relax_points.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "base/eigen_vec.hpp"
#include "setup/point_grid.hpp"
#include "setup/smoothing_kernel.hpp"

namespace drench {
namespace {

using Eigen::Vector3d;

/// B(s) and its derivative (1/m): the part of the kernel beyond a plane at distance s.
class WallShare {
 public:
  WallShare(KernelKind kernel, double support) : support_(support) {
    // B(s) = ∫_s^h 2π r W(r) (r − s) dr: a sphere of radius r has 2π r (r − s) of its area beyond the plane.
    constexpr int parts = 400;
    for (std::size_t k = 0; k < share_.size(); ++k) {
      const double s = support * static_cast<double>(k) / steps;
      double sum = 0;
      for (int p = 0; p < parts; ++p) {
        const double r = s + (support - s) * (p + 0.5) / parts;
        sum += 2 * std::numbers::pi * r * (r - s) * kernel_value(kernel, r, support);
      }
      share_[k] = sum * (support - s) / parts;
    }
  }
  double operator()(double s, double& derivative) const {
    const double step = support_ / steps, at = std::clamp(std::abs(s) / step, 0.0, static_cast<double>(steps));
    const auto k = std::min(static_cast<std::size_t>(at), static_cast<std::size_t>(steps - 1));
    derivative = at < steps ? (share_[k + 1] - share_[k]) / step : 0;
    const double value = share_[k] + (at - static_cast<double>(k)) * (share_[k + 1] - share_[k]);
    return s < 0 ? 1 - value : value;
  }

 private:
  static constexpr int steps = 64;
  double support_;
  std::array<double, steps + 1> share_{};
};

/// What a particle's constraint says of one round.
struct Constraint {
  double lambda = 0;  // m²
  double wall = 0;    // B′, 1/m
  Vector3d inward = Vector3d::Zero();
};

}  // namespace

void relax_points(std::vector<Vec3>& points, double volume, const Depth& depth, KernelKind kernel, double support) {
  constexpr int most = 100;
  constexpr double reach = 2.5, enough = 0.01;  // spacings; 1
  const double spacing = std::cbrt(volume), alone = volume * kernel_value(kernel, 0, support);
  const double softness = 1e-3 / (spacing * spacing);
  const WallShare wall_share(kernel, support);
  std::vector<std::size_t> moving;  // the grid has these first
  std::vector<Vec3> resting;
  for (std::size_t i = 0; i < points.size(); ++i) {
    Vec3 inward;
    if (depth(points[i], inward) < reach * spacing)
      moving.push_back(i);
    else
      resting.push_back(points[i]);
  }
  std::vector<Constraint> constraint(moving.size());
  for (int round = 0; round < most; ++round) {
    PointGrid grid(support);
    for (const std::size_t i : moving) grid.add(points[i]);
    for (const Vec3& x : resting) grid.add(x);
    const auto for_neighbors = [&](std::size_t k, const auto& visit) {
      const Vector3d x = to_eigen(points[moving[k]]);
      grid.for_box(to_vec3(x.array() - support), to_vec3(x.array() + support), [&](Index p) {
        const auto other = static_cast<std::size_t>(p);
        const Vector3d away = x - to_eigen(grid.points()[other]);
        const double r = away.norm();
        if (other != k && r < support && r > 0) visit(other, away, r);
      });
    };
    double densest = 0;
    for (std::size_t k = 0; k < moving.size(); ++k) {
      Constraint& c = constraint[k];
      Vec3 inward;
      const double s = depth(points[moving[k]], inward);
      c.inward = to_eigen(inward);
      double density = alone + wall_share(s, c.wall), squares = 0;
      Vector3d own = c.wall * c.inward;
      for_neighbors(k, [&](std::size_t, const Vector3d& away, double r) {
        density += volume * kernel_value(kernel, r, support);
        const Vector3d gradient = volume * kernel_derivative(kernel, r, support) * away;
        own += gradient;
        squares += gradient.squaredNorm();
      });
      densest = std::max(densest, density);
      c.lambda = density > 1 ? -(density - 1) / (own.squaredNorm() + squares + softness) : 0;
    }
    if (densest < 1 + enough) return;
    std::vector<Vec3> next(moving.size());
    for (std::size_t k = 0; k < moving.size(); ++k) {
      const Constraint& c = constraint[k];
      Vector3d move = c.lambda * c.wall * c.inward;
      for_neighbors(k, [&](std::size_t other, const Vector3d& away, double r) {
        const double both = c.lambda + (other < moving.size() ? constraint[other].lambda : 0);
        move += both * volume * kernel_derivative(kernel, r, support) * away;
      });
      const double longest = 0.1 * spacing;
      next[k] = to_vec3(to_eigen(points[moving[k]]) + std::min(1.0, longest / std::max(move.norm(), 1e-300)) * move);
    }
    for (std::size_t k = 0; k < moving.size(); ++k) points[moving[k]] = next[k];
  }
}

}  // namespace drench
