// A cup that is filled, lifted, moved and poured out by a program: none of its liquid passes its wall.

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>

#include "base/eigen_vec.hpp"
#include "drench/drench.hpp"
#include "run_program.hpp"
#include "state/mass_budget.hpp"

namespace drench::test {
namespace {

using Eigen::Vector3d;

constexpr double inner = 0.05, height = 0.12, wall = 0.01, floor_depth = 0.01, level = 0.08, spacing = 0.008;  // m
constexpr int parts = 48;

/// OBJ text of a solid of revolution about y; the profile runs from the axis outwards and back to it, upwards first.
std::string revolved(const std::vector<std::array<double, 2>>& profile) {
  std::string points, faces;
  std::vector<std::vector<int>> rings;
  int count = 0;
  for (const auto& [r, y] : profile) {
    std::vector<int> ring;
    for (int j = 0; j < parts; ++j) {
      if (r > 0 || j == 0) {
        const double a = 2 * std::numbers::pi * j / parts;
        points += fmt::format("v {:.9g} {:.9g} {:.9g}\n", r * std::cos(a), y, r * std::sin(a));
        ++count;
      }
      ring.push_back(count);
    }
    rings.push_back(ring);
  }
  for (std::size_t k = 0; k + 1 < rings.size(); ++k)
    for (std::size_t j = 0; j < parts; ++j) {
      const std::size_t next = (j + 1) % parts;
      const int a = rings[k][j], b = rings[k][next], c = rings[k + 1][j], d = rings[k + 1][next];
      if (a != b) faces += fmt::format("f {} {} {}\n", a, c, b);
      if (c != d) faces += fmt::format("f {} {} {}\n", b, c, d);
    }
  return points + faces;
}

class Cup : public ::testing::Test {
 protected:
  Cup() {
    write_text(folder_.path() / "cup.obj", revolved({{0, -floor_depth},
                                                     {inner + wall, -floor_depth},
                                                     {inner + wall, height},
                                                     {inner, height},
                                                     {inner, 0},
                                                     {0, 0}}));
    write_text(folder_.path() / "liquid.obj", revolved({{0, 0}, {inner, 0}, {inner, level}, {0, level}}));
    const std::string folder = folder_.path().string();
    run_.emplace(parse_scene(fmt::format("drench: 1\ntime: {{step: 0.002, end: 10}}\n"
                                         "domain: {{min: [-0.6, -0.3, -0.6], max: [0.6, 1, 0.6]}}\n"
                                         "fluid: {{spacing: {}, sources: [{{mesh: {{file: \"{}/liquid.obj\"}}}}]}}\n"
                                         "bodies:\n  - name: cup\n    mesh: {{file: \"{}/cup.obj\", commanded: true}}\n"
                                         "  - plane: {{point: [0, -0.2, 0], normal: [0, 1, 0]}}\n",
                                         spacing, folder, folder),
                             "cup.yaml"));
    start_ = to_eigen(run_->body_motion(0).position);
  }

  /// Steadily from one velocity along `axis` to another, m/s.
  void accelerate(double from, double to, double duration, std::size_t axis) {
    const double begin = run_->time();
    while (run_->time() < begin + duration - 1e-9) {
      Vec3 velocity{0, 0, 0};
      velocity[axis] = from + (to - from) * std::min(1.0, (run_->time() - begin + 0.002) / duration);
      run_->set_body_velocity(0, velocity);
      run_->step();
      expect_all_inside();
    }
  }
  /// None is below the floor or beside the wall, and none deeper in them than half a spacing.
  void expect_all_inside() const {
    const BodyMotion cup = run_->body_motion(0);
    const auto& q = cup.orientation;
    const Eigen::Quaterniond turn(q[0], q[1], q[2], q[3]);
    for (const Vec3& x : run_->state().fluid_position) {
      const Vector3d at = turn.conjugate() * (to_eigen(x) - to_eigen(cup.position)) + start_;
      const double r = std::hypot(at[0], at[2]);
      EXPECT_GT(at[1], -0.5 * spacing) << r;
      if (at[1] < height) {
        EXPECT_LT(r, inner + 0.5 * spacing) << at[1];
      }
    }
  }

  TempFolder folder_;
  std::optional<Simulation> run_;
  Vector3d start_;
};

TEST_F(Cup, HoldsItsLiquidWhileItMovesAndIsPouredOut) {
  const HostState full = run_->state();
  const Quanta mass = liquid_budget(full);
  const double area = 0.5 * parts * std::sin(2 * std::numbers::pi / parts) * inner * inner;
  EXPECT_NEAR(static_cast<double>(mass) * run_->quantum(), 1000 * area * level, 1e-6);
  run_->run_until(0.3);
  expect_all_inside();
  accelerate(0, 2, 0.2, 1);
  accelerate(2, 2, 0.05, 1);
  accelerate(2, 0, 0.4, 1);
  accelerate(0, 0.5, 0.3, 0);
  accelerate(0.5, -0.5, 0.4, 0);
  accelerate(-0.5, 0, 0.3, 0);
  const double half = 55 * std::numbers::pi / 180;
  run_->set_body_pose(0, run_->body_motion(0).position, {std::cos(half), 0, 0, std::sin(half)}, 1.0);
  run_->run_until(run_->time() + 1.5);
  const HostState poured = run_->state();
  EXPECT_EQ(liquid_budget(poured), mass);
  EXPECT_EQ(poured.drained, sum_of(full.fluid_mass) - sum_of(poured.fluid_mass));
  const auto lower = std::count_if(poured.fluid_position.begin(), poured.fluid_position.end(),
                                   [](const Vec3& x) { return x[1] < 0.1; });
  EXPECT_GT(static_cast<double>(lower) + static_cast<double>(full.fluid_position.size() - poured.fluid_position.size()),
            0.6 * static_cast<double>(full.fluid_position.size()));
}

}  // namespace
}  // namespace drench::test
