// Stage bodies: the samples of planes that move and turn (src/stages/bodies.hpp, law 1).

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <array>
#include <cmath>
#include <set>
#include <utility>

#include "base/eigen_vec.hpp"
#include "pipeline/pipeline.hpp"
#include "stage_compare.hpp"

namespace drench::test {

/// A belt that runs for long: its samples are a lattice that moves with it and covers the domain.
TEST(bodies, a_plane_that_slides_needs_no_more_samples_than_one_at_rest) {
  const std::string belt = R"(drench: 1
time: {step: 0.01, end: 10}
domain: {min: [-0.3, -0.1, -0.3], max: [0.3, 0.3, 0.3]}
fluid: {spacing: 0.02, sources: [{block: {min: [-0.1, 0.15, -0.1], max: [0.1, 0.2, 0.1]}}]}
bodies: [{plane: {point: [0, 0, 0], normal: [0, 1, 0], velocity: VELOCITY}}]
)";
  const auto still = setup_from(with(belt, "VELOCITY", "[0, 0, 0]")),
             setup = setup_from(with(belt, "VELOCITY", "[2, 0.01, -1.3]"));
  EXPECT_LT(setup.model.boundary.count(), 1.15 * still.model.boundary.count());
  const double time = 7.3, d = 0.02, reach = 0.333;  // m: no lattice point is there
  const double way[3] = {2 * time, 0.01 * time, -1.3 * time};
  const StepInfo info{0, time - 0.01, 0.01};
  run_on_both(setup.model, setup.state, {Stage::bodies}, info, [&](const Backend& backend, const StepReport&) {
    const HostState s = backend.download();
    std::set<std::pair<long, long>> places;  // on the lattice that has moved
    for (std::size_t b = 0; b < s.boundary_position.size(); ++b) {
      const Vec3 &x = s.boundary_position[b], &rest = setup.state.boundary_position[b];
      EXPECT_NEAR(x[1], rest[1] + way[1], 1e-6);
      EXPECT_NEAR(s.boundary_velocity[b][0], 2, 1e-6);
      EXPECT_NEAR(s.boundary_velocity[b][2], -1.3, 1e-6);
      const double i = (x[0] - way[0]) / d, k = (x[2] - way[2]) / d;
      EXPECT_NEAR(i, std::round(i), 1e-3);
      EXPECT_NEAR(k, std::round(k), 1e-3);
      if (std::abs(x[0]) <= reach && std::abs(x[2]) <= reach) places.insert({std::lround(i), std::lround(k)});
    }
    const auto lattice = [&](double offset) {
      return std::floor((reach - offset) / d) - std::ceil((-reach - offset) / d) + 1;
    };
    EXPECT_EQ(static_cast<double>(places.size()), lattice(way[0]) * lattice(way[2]));
  });
}

/// A floor that flies and turns for long, with a support of three spacings, so two layers of samples.
TEST(bodies, a_plane_that_turns_has_the_samples_that_the_domain_meets_and_no_more) {
  const std::string floor = R"(drench: 1
time: {step: 0.01, end: END}
domain: {min: [-0.3, -0.1, -0.3], max: [0.2, 0.3, 0.3]}
fluid: {spacing: 0.02, support: 3, sources: [{block: {min: [-0.1, 0.15, -0.1], max: [0.1, 0.2, 0.1]}}]}
bodies: [{plane: {point: [0.4, 0.1, 0.1], normal: [1, 2, -1], velocity: [VELOCITY, 0.1, 0.2],
                  spin: {axis: [1, 0.3, 0.2], degrees_per_second: 100}}}]
)";
  const double d = 0.02, time = 7.29, velocity = -0.09, reach = 0.05;  // m
  const auto setup = setup_from(with(with(floor, "VELOCITY", "-0.09"), "END", "10"));
  EXPECT_EQ(setup.model.boundary.count(),
            setup_from(with(with(floor, "VELOCITY", "-0.9"), "END", "1000")).model.boundary.count());
  const Body& body = setup.model.bodies[0];
  const auto [first, second] = body.lattice;
  const Eigen::Vector3d center = to_eigen(body.center) + time * Eigen::Vector3d(velocity, 0.1, 0.2),
                        spin = body.spin_rate.plain() * to_eigen(body.spin_axis);
  const Eigen::Quaterniond turn(Eigen::AngleAxisd(body.spin_rate.plain() * time, to_eigen(body.spin_axis)));
  const auto inside = [&](const Eigen::Vector3d& x) {
    bool all = true;
    for (int a = 0; a < 3; ++a)
      all = all && x[a] >= setup.model.scene.domain.min[static_cast<std::size_t>(a)] - reach &&
            x[a] <= setup.model.scene.domain.max[static_cast<std::size_t>(a)] + reach;
    return all;
  };
  using Place = std::array<long, 3>;  // layer and the two coordinates on the lattice that has moved and turned
  std::set<Place> expected;
  for (long layer = 0; layer < 2; ++layer)
    for (long i = -200; i <= 200; ++i)
      for (long j = -200; j <= 200; ++j)
        if (inside(center +
                   turn * (static_cast<double>(i) * to_eigen(first) + static_cast<double>(j) * to_eigen(second) -
                           (static_cast<double>(layer) + 0.5) * d * to_eigen(body.normal))))
          expected.insert({layer, i, j});
  ASSERT_GT(expected.size(), 1000u);
  const StepInfo info{0, time - 0.01, 0.01};
  run_on_both(setup.model, setup.state, {Stage::bodies}, info, [&](const Backend& backend, const StepReport&) {
    const HostState s = backend.download();
    std::set<Place> places;
    for (std::size_t b = 0; b < s.boundary_position.size(); ++b) {
      const Eigen::Vector3d x = to_eigen(s.boundary_position[b]), own = turn.conjugate() * (x - center);
      const double u = own.dot(to_eigen(first)) / (d * d), v = own.dot(to_eigen(second)) / (d * d),
                   depth = -own.dot(to_eigen(body.normal)) / d - 0.5;
      for (const double whole : {u, v, depth}) EXPECT_NEAR(whole, std::round(whole), 1e-3);
      EXPECT_LT(
          (to_eigen(s.boundary_velocity[b]) - Eigen::Vector3d(velocity, 0.1, 0.2) - spin.cross(x - center)).norm(),
          1e-5);
      if (!inside(x)) continue;
      EXPECT_TRUE(places.insert({std::lround(depth), std::lround(u), std::lround(v)}).second);
    }
    EXPECT_EQ(places, expected);
  });
}

}  // namespace drench::test
