// Particles along a wall are moved until none is denser than at rest.

#include "setup/relax_points.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <numbers>
#include <string>

#include "base/eigen_vec.hpp"
#include "setup/smoothing_kernel.hpp"

namespace drench::test {
namespace {

constexpr double spacing = 0.02, support = 0.04, radius = 0.15;

/// Of a ball.
double depth(const Vec3& x, Vec3& inward) {
  const Eigen::Vector3d at = to_eigen(x);
  inward = to_vec3(at.norm() > 0 ? Eigen::Vector3d(-at.normalized()) : Eigen::Vector3d::UnitX());
  return radius - at.norm();
}

/// A lattice in the ball whose outer layers are pushed against the wall.
std::vector<Vec3> crowded() {
  std::vector<Vec3> points;
  const int n = static_cast<int>(radius / spacing) + 1;
  for (int i = -n; i <= n; ++i)
    for (int j = -n; j <= n; ++j)
      for (int k = -n; k <= n; ++k) {
        Eigen::Vector3d x = spacing * (Eigen::Vector3d(i, j, k) + Eigen::Vector3d::Constant(0.5));
        const double far = x.norm();
        if (far >= radius) continue;
        if (far > radius - 2 * spacing) x *= (far + 0.3 * (radius - far)) / far;
        points.push_back(to_vec3(x));
      }
  return points;
}

/// ∫ W beyond a plane at distance s, by the midpoint rule.
double beyond(double s) {
  constexpr int steps = 60;
  double sum = 0;
  for (int a = 0; a < steps; ++a) {
    const double z = s + (support - s) * (a + 0.5) / steps;
    for (int b = 0; b < steps; ++b) {
      const double r = z + (support - z) * (b + 0.5) / steps;
      sum += 2 * std::numbers::pi * r * kernel_value(KernelKind::cubic, r, support) * (support - z) / steps *
             (support - s) / steps;
    }
  }
  return sum;
}

/// The largest density over that at rest, beside the wall as beside a plane.
double densest(const std::vector<Vec3>& points, double volume) {
  double most = 0;
  for (const Vec3& x : points) {
    Vec3 inward;
    const double s = depth(x, inward);
    double sum = s < support ? beyond(s) : 0;
    for (const Vec3& y : points)
      sum += volume * kernel_value(KernelKind::cubic, (to_eigen(x) - to_eigen(y)).norm(), support);
    most = std::max(most, sum);
  }
  return most;
}

}  // namespace

TEST(relax_points, leaves_no_particle_denser_than_at_rest) {
  const double volume = std::pow(spacing, 3);
  const std::vector<Vec3> before = crowded();
  ASSERT_GT(densest(before, volume), 1.1);
  std::vector<Vec3> after = before;
  relax_points(after, volume, depth, KernelKind::cubic, support);
  EXPECT_LT(densest(after, volume), 1.02);
  ASSERT_EQ(after.size(), before.size());
  int moved = 0;
  for (std::size_t i = 0; i < before.size(); ++i) {
    Vec3 inward;
    EXPECT_GT(depth(after[i], inward), 0) << i;
    moved += after[i] != before[i];
    if (depth(before[i], inward) > 2.5 * spacing) {
      EXPECT_EQ(after[i], before[i]) << "too deep to move";
    }
  }
  EXPECT_GT(moved, 100);
}

TEST(relax_points, does_not_depend_on_the_number_of_threads) {
  const char* given = std::getenv("OMP_NUM_THREADS");
  const std::string before = given ? given : "";
  const auto relaxed = [](const char* threads) {
    setenv("OMP_NUM_THREADS", threads, 1);  // host_threads reads it
    std::vector<Vec3> points = crowded();
    relax_points(points, std::pow(spacing, 3), depth, KernelKind::cubic, support);
    return points;
  };
  const std::vector<Vec3> one = relaxed("1"), three = relaxed("3");
  given ? setenv("OMP_NUM_THREADS", before.c_str(), 1) : unsetenv("OMP_NUM_THREADS");
  EXPECT_EQ(one, three);
}

}  // namespace drench::test
