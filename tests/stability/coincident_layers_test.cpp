// Layers of cloth that start in one place: seams of doubled points, sheets on each other. Contact only pushes.

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>

#include "hard_scene.hpp"

namespace drench::test {
namespace {

/// Two strips of 0.2 m × 0.1 m, one below the other; the nodes along their common edge are doubled. The upper one is
/// held.
std::string strips(double friction, bool self_collision) {
  return fmt::format(R"(drench: 1
time: {{step: 0.002, end: 10}}
cloth_solver: {{tolerance: 1.0e-5}}
cloth:
  - name: upper
    mesh: {{grid: {{size: [0.2, 0.1], nodes: [11, 6]}}}}
    place: {{position: [0, 0.05, 0], rotate: {{axis: [1, 0, 0], degrees: 90}}}}
    self_collision: {0}
    friction: {1}
    pin: [{{box: {{min: [-1, 0.09, -1], max: [1, 1, 1]}}}}]
  - name: lower
    mesh: {{grid: {{size: [0.2, 0.1], nodes: [11, 6]}}}}
    place: {{position: [0, -0.05, 0], rotate: {{axis: [1, 0, 0], degrees: 90}}}}
    self_collision: {0}
    friction: {1}
)",
                     self_collision, friction);
}

double mean_height(const WatchedRun& run, Index cloth) {
  const ClothMaterial& c = run.model().cloths[static_cast<std::size_t>(cloth)];
  double sum = 0;
  for (Index n = c.first_node; n < c.first_node + c.node_count; ++n)
    sum += run.state().node_position[static_cast<std::size_t>(n)][1] / c.node_count;
  return sum;
}

/// How far the lower strip falls in 0.2 s.
double fall(double friction, bool self_collision) {
  WatchedRun run(strips(friction, self_collision));
  const double before = mean_height(run, 1);
  run.steps(100);
  return before - mean_height(run, 1);
}

}  // namespace

TEST(coincident_layers, a_seam_of_doubled_points_holds_nothing) {
  const double free = fall(0, false);
  EXPECT_NEAR(free, 0.5 * 9.81 * 0.2 * 0.2, 0.06 * free) << "less what damping takes";
  EXPECT_NEAR(fall(0, true), free, 0.02 * free);
  // In free fall only the push that opens the seam presses the layers together.
  EXPECT_NEAR(fall(0.4, true), free, 0.1 * free);
}

namespace {

/// How far the one of two sheets falls in 0.2 s that is not held. They have different meshes and lie in one place.
double fall_off(bool first_is_held, const char* gravity, bool self_collision) {
  const auto sheet = [&](const char* nodes, bool held) {
    return fmt::format("  - name: {}\n    mesh: {{grid: {{size: [0.2, 0.2], nodes: {}}}}}\n    self_collision: {}\n{}",
                       held ? "held" : "free", nodes, self_collision, held ? "    dynamics: false\n" : "");
  };
  WatchedRun run(fmt::format("drench: 1\ntime: {{step: 0.002, end: 10}}\ngravity: {}\ncloth:\n{}{}", gravity,
                             sheet("[8, 9]", first_is_held), sheet("[9, 7]", !first_is_held)));
  run.steps(100);
  return std::abs(mean_height(run, first_is_held ? 1 : 0));
}

}  // namespace

/// To either side, whichever is held. What opens the layers, a tenth of the thickness a step, helps a little.
TEST(coincident_layers, a_sheet_falls_off_the_one_that_it_lies_in) {
  for (const bool first_is_held : {true, false})
    for (const char* gravity : {"[0, -9.81, 0]", "[0, 9.81, 0]"}) {
      SCOPED_TRACE(fmt::format("{} {}", first_is_held, gravity));
      const double free = fall_off(first_is_held, gravity, false);
      EXPECT_NEAR(fall_off(first_is_held, gravity, true), free, 0.05 * free);
    }
}

/// One of two sheets is pulled off by its corners: the other one, which nothing holds, stays where it is.
TEST(coincident_layers, a_sheet_is_pulled_off_another_one) {
  for (const double speed : {0.2, -0.2}) {
    SCOPED_TRACE(speed);
    WatchedRun run(fmt::format(R"(drench: 1
time: {{step: 0.002, end: 10}}
gravity: [0, 0, 0]
cloth:
  - name: pulled
    mesh: {{grid: {{size: [0.2, 0.2], nodes: [9, 9]}}}}
    self_collision: true
    friction: 0.4
    pin: [{{edges: true, velocity: [0, {}, 0]}}]
  - name: other
    mesh: {{grid: {{size: [0.2, 0.2], nodes: [9, 9]}}}}
    self_collision: true
    friction: 0.4
)",
                               speed));
    run.steps(150);
    EXPECT_NEAR(mean_height(run, 0), 0.3 * speed, 0.05 * std::abs(0.3 * speed));
    EXPECT_LT(std::abs(mean_height(run, 1)), 0.15 * std::abs(0.3 * speed));
  }
}

}  // namespace drench::test
