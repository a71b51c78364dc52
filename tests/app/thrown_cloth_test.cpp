// Cloth with an initial velocity.

#include <gtest/gtest.h>

#include "drench/drench.hpp"

namespace drench::test {
namespace {

constexpr double dt = 0.002;  // s

/// Two sheets, of which the second is held by its first node.
Scene two_thrown_sheets() {
  return parse_scene(R"(drench: 1
time: {step: 0.002, end: 1, mode: fixed}
domain: {min: [-5, -5, -5], max: [5, 5, 5]}
cloth:
  - name: free
    mesh: {grid: {size: [0.2, 0.2], nodes: [5, 5]}}
    damping: 0
    velocity: [1, 2, -0.5]
  - name: held
    mesh: {grid: {size: [0.2, 0.2], nodes: [5, 5]}}
    place: {position: [2, 0, 0]}
    damping: 0
    velocity: [1, 2, -0.5]
    pin: [{nodes: [0]}]
)",
                     "thrown.yaml");
}

TEST(thrown_cloth, flies_as_a_point_mass_does) {
  Simulation run(two_thrown_sheets());
  const HostState start = run.state();
  constexpr int steps = 100;
  run.run_until(steps * dt);
  const HostState now = run.state();
  // Implicit Euler: y = y₀ + v t − g Δt² n (n + 1)/2.
  const double fallen = 9.81 * dt * dt * steps * (steps + 1) / 2;
  for (std::size_t n = 0; n < 25; ++n) {
    EXPECT_NEAR(now.node_position[n][0] - start.node_position[n][0], 1 * steps * dt, 1e-5) << "node " << n;
    EXPECT_NEAR(now.node_position[n][1] - start.node_position[n][1], 2 * steps * dt - fallen, 1e-5) << "node " << n;
    EXPECT_NEAR(now.node_position[n][2] - start.node_position[n][2], -0.5 * steps * dt, 1e-5) << "node " << n;
  }
}

TEST(thrown_cloth, pinned_nodes_start_at_rest) {
  const HostState start = Simulation(two_thrown_sheets()).state();
  EXPECT_EQ(start.node_velocity[25], (Vec3{0, 0, 0}));
  EXPECT_EQ(start.node_velocity[26], (Vec3{1, 2, -0.5}));
}

}  // namespace
}  // namespace drench::test
