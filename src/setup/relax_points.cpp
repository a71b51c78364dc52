#include "setup/relax_points.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <optional>
#include <utility>

#include "base/eigen_vec.hpp"
#include "base/for_ranges.hpp"
#include "base/free_cores.hpp"
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
  double density = 0;  // 1
  double lambda = 0;   // m²
  double wall = 0;     // B′, 1/m
  Vector3d inward = Vector3d::Zero();
};

/// For each of the first `rows` points: all others that are closer than `distance`.
class Near {
 public:
  Near(const std::vector<Vec3>& points, std::size_t rows, double distance, int threads) : others_(rows) {
    PointGrid grid(distance);
    for (const Vec3& x : points) grid.add(x);
    for_ranges(rows, threads, [&](std::size_t k) {
      const Vector3d x = to_eigen(points[k]);
      grid.for_box(to_vec3(x.array() - distance), to_vec3(x.array() + distance), [&](Index p) {
        const auto other = static_cast<std::size_t>(p);
        if (other != k && (x - to_eigen(points[other])).squaredNorm() < distance * distance) others_[k].push_back(p);
      });
    });
  }
  const std::vector<Index>& operator[](std::size_t k) const { return others_[k]; }

 private:
  std::vector<std::vector<Index>> others_;
};

/// The particles that move come first, then those that they may come near to.
class Relaxation {
 public:
  Relaxation(std::vector<Vec3> points, std::size_t moving, double volume, const Depth& depth, KernelKind kernel,
             double support)
      : points_(std::move(points)),
        moving_(moving),
        volume_(volume),
        depth_(depth),
        kernel_(kernel),
        support_(support),
        spacing_(std::cbrt(volume)),
        alone_(volume * kernel_value(kernel, 0, support)),
        wall_share_(kernel, support),
        constraint_(moving),
        changed_(moving, 1) {}

  void run() {
    for (int round = 0; round < most_rounds; ++round) {
      if (!near_) {
        near_.emplace(points_, moving_, support_ + 2 * farthest * spacing_, threads_);
        listed_ = points_;
      }
      for_ranges(moving_, threads_, [this](std::size_t k) {
        if (changed_[k] != 0) constrain(k);
      });
      const auto densest = std::max_element(constraint_.begin(), constraint_.end(),
                                            [](const auto& a, const auto& b) { return a.density < b.density; });
      if (densest == constraint_.end() || densest->density < 1 + enough) return;
      move();
    }
  }
  const Vec3& point(std::size_t k) const { return points_[k]; }

 private:
  static constexpr int most_rounds = 100;
  static constexpr double enough = 0.01;   // 1
  static constexpr double longest = 0.1;   // spacings per round
  static constexpr double farthest = 0.3;  // spacings, while the same lists are used

  template <class Visit>
  void for_neighbors(std::size_t k, const Visit& visit) const {
    const Vector3d x = to_eigen(points_[k]);
    for (const Index p : (*near_)[k]) {
      const auto other = static_cast<std::size_t>(p);
      const Vector3d away = x - to_eigen(points_[other]);
      const double r = away.norm();
      if (r < support_ && r > 0) visit(other, away, r);
    }
  }

  void constrain(std::size_t k) {
    Constraint& c = constraint_[k];
    Vec3 inward;
    const double s = depth_(points_[k], inward), softness = 1e-3 / (spacing_ * spacing_);
    c.inward = to_eigen(inward);
    c.density = alone_ + wall_share_(s, c.wall);
    double squares = 0;
    Vector3d own = c.wall * c.inward;
    for_neighbors(k, [&](std::size_t, const Vector3d& away, double r) {
      c.density += volume_ * kernel_value(kernel_, r, support_);
      const Vector3d gradient = volume_ * kernel_derivative(kernel_, r, support_) * away;
      own += gradient;
      squares += gradient.squaredNorm();
    });
    // The others wait: if all that are slightly denser moved in each round, all of them would have to be looked at.
    c.lambda = c.density > 1 + enough / 2 ? -(c.density - 1) / (own.squaredNorm() + squares + softness) : 0;
  }

  /// By the constraints of a particle and of its neighbours. Marks those whose density may change by it.
  void move() {
    std::vector<std::uint8_t> moves(moving_, 0);
    for (std::size_t k = 0; k < moving_; ++k)
      if (constraint_[k].lambda != 0) mark_around(k, moves);
    std::vector<Vec3> next(moving_);
    for_ranges(moving_, threads_, [&](std::size_t k) {
      if (moves[k] == 0) return;
      const Constraint& c = constraint_[k];
      Vector3d move = c.lambda * c.wall * c.inward;
      for_neighbors(k, [&](std::size_t other, const Vector3d& away, double r) {
        const double both = c.lambda + (other < moving_ ? constraint_[other].lambda : 0);
        move += both * volume_ * kernel_derivative(kernel_, r, support_) * away;
      });
      next[k] =
          to_vec3(to_eigen(points_[k]) + std::min(1.0, longest * spacing_ / std::max(move.norm(), 1e-300)) * move);
    });
    std::fill(changed_.begin(), changed_.end(), std::uint8_t{0});
    double squared = 0;
    for (std::size_t k = 0; k < moving_; ++k) {
      if (moves[k] == 0) continue;
      points_[k] = next[k];
      squared = std::max(squared, (to_eigen(next[k]) - to_eigen(listed_[k])).squaredNorm());
      mark_around(k, changed_);
    }
    if (std::sqrt(squared) > (farthest - longest) * spacing_) near_.reset();  // before the next round goes too far
  }
  void mark_around(std::size_t k, std::vector<std::uint8_t>& marks) const {
    marks[k] = 1;
    for (const Index p : (*near_)[k])
      if (static_cast<std::size_t>(p) < moving_) marks[static_cast<std::size_t>(p)] = 1;
  }

  std::vector<Vec3> points_, listed_;  // now; when the lists were made
  std::size_t moving_;
  double volume_;
  const Depth& depth_;
  KernelKind kernel_;
  double support_, spacing_, alone_;
  WallShare wall_share_;
  std::optional<Near> near_;
  std::vector<Constraint> constraint_;
  std::vector<std::uint8_t> changed_;  // has moved in the last round, or is near one that has
  int threads_ = std::min(host_threads(), static_cast<int>(1 + moving_ / 1000));  // fewer take longer to start
};

}  // namespace

void relax_points(std::vector<Vec3>& points, double volume, const Depth& depth, KernelKind kernel, double support) {
  constexpr double reach = 2.5;  // spacings
  const double spacing = std::cbrt(volume);
  std::vector<std::size_t> moving;
  std::vector<Vec3> all, resting;
  for (std::size_t i = 0; i < points.size(); ++i) {
    Vec3 inward;
    const double s = depth(points[i], inward);
    if (s < reach * spacing) {
      moving.push_back(i);
      all.push_back(points[i]);
    } else if (s < (reach + 1) * spacing + support) {  // as far as moving ones come, and see
      resting.push_back(points[i]);
    }
  }
  all.insert(all.end(), resting.begin(), resting.end());
  Relaxation relaxation(std::move(all), moving.size(), volume, depth, kernel, support);
  relaxation.run();
  for (std::size_t k = 0; k < moving.size(); ++k) points[moving[k]] = relaxation.point(k);
}

}  // namespace drench
