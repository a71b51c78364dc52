// Nodes of cloth that are attached to bodies: where they go, what they pull with, how they come free.

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "base/eigen_vec.hpp"
#include "drench/drench.hpp"
#include "run_program.hpp"

namespace drench::test {
namespace {

using Eigen::Vector3d;

constexpr double weight = 0.3 * 0.2 * 0.2 * 9.81;  // N, of the towel

/// A towel below a gripper; `pin` are keys of the cloth.
Scene scene(const std::string& pin = "") {
  return parse_scene(R"(drench: 1
time: {step: 0.002, end: 10}
domain: {min: [-1, -1, -1], max: [1, 1, 1]}
cloth:
  - name: towel
    mesh: {grid: {size: [0.2, 0.2], nodes: [9, 9]}}
    place: {rotate: {axis: [1, 0, 0], degrees: 90}}
    areal_density: 0.3
    damping: 8
)" + pin + R"(bodies:
  - name: gripper
    box: {min: [-0.12, 0.101, -0.02], max: [0.12, 0.14, 0.02], commanded: true}
  - name: wheel
    box: {min: [0.5, 0.5, 0.5], max: [0.6, 0.6, 0.6], velocity: [0.1, 0, 0],
        spin: {axis: [0, 0, 1], degrees_per_second: 90}}
)",
                     "attachments.yaml");
}

/// The nine nodes of the upper edge.
std::vector<Index> upper(const HostState& s) {
  std::vector<Index> nodes;
  for (std::size_t n = 0; n < s.node_position.size(); ++n)
    if (s.node_position[n][1] > 0.0999) nodes.push_back(static_cast<Index>(n));
  return nodes;
}

std::string list_of(const std::vector<Index>& nodes) {
  std::string text;
  for (const Index n : nodes) text += (text.empty() ? "" : ", ") + std::to_string(n);
  return "    pin: [{nodes: [" + text + "], body: gripper}]\n";
}

/// The farthest that a node is from where a turn by `angle` about z and a shift bring it from its start, m.
double off_the_way(const HostState& now, const HostState& start, const std::vector<Index>& nodes,
                   const Vector3d& center, const Vector3d& shift, double angle) {
  double worst = 0;
  for (const Index n : nodes) {
    const auto i = static_cast<std::size_t>(n);
    const Vector3d there =
        center + shift + Eigen::AngleAxisd(angle, Vector3d::UnitZ()) * (to_eigen(start.node_position[i]) - center);
    worst = std::max(worst, (to_eigen(now.node_position[i]) - there).norm());
  }
  return worst;
}

TEST(attachments, soft_pins_carry_the_weight_with_their_stiffness_and_let_go) {
  constexpr double stiffness = 20;  // N/m
  const std::vector<Index> nodes = upper(Simulation(scene()).state());
  std::string pin = list_of(nodes);
  pin.insert(pin.find("}]"), ", stiffness: " + std::to_string(stiffness));
  Simulation run(scene(pin));
  const HostState start = run.state();
  EXPECT_EQ(run.attached(0), nodes);
  run.run_until(3);
  const HostState rest = run.state();
  double sag = 0, share = 0;
  for (std::size_t k = 0; k < nodes.size(); ++k) {
    const auto n = static_cast<std::size_t>(nodes[k]);
    const double part = k == 0 || k + 1 == nodes.size() ? 0.5 : 1;  // of the stiffness: as the nodes' masses
    sag += part * (start.node_position[n][1] - rest.node_position[n][1]);
    share += part;
  }
  EXPECT_NEAR(sag / share, weight / stiffness, 2e-3 * weight / stiffness) << "m";
  EXPECT_NEAR(run.body_load(0).attached_force[1], -weight, 2e-3 * weight) << "N, on the gripper";
  // They follow the body: 0.1 m/s upwards, steadily with the same sag.
  run.set_body_velocity(0, {0, 0.1, 0}, {0, 0, 0});
  run.run_until(5);
  double risen = 0;
  for (std::size_t k = 0; k < nodes.size(); ++k) {
    const auto n = static_cast<std::size_t>(nodes[k]);
    risen += (k == 0 || k + 1 == nodes.size() ? 0.5 : 1) * (run.state().node_position[n][1] - rest.node_position[n][1]);
  }
  const double drag = 8 * 0.1 * 0.3 * 0.04;  // N, of `damping`
  EXPECT_NEAR(risen / share, 0.2 - drag / stiffness, 2e-4) << "m";
  run.detach(0, nodes);
  run.run_until(5.4);
  EXPECT_LT(run.state().node_position[static_cast<std::size_t>(nodes[4])][1],
            rest.node_position[static_cast<std::size_t>(nodes[4])][1] + 0.1);
  EXPECT_EQ(run.body_load(0).attached_force[1], 0);
}

TEST(attachments, soft_pins_let_go_at_their_time) {
  const std::vector<Index> nodes = upper(Simulation(scene()).state());
  std::string pin = list_of(nodes);
  pin.insert(pin.find("}]"), ", stiffness: 200, release: 3");
  Simulation run(scene(pin));
  const HostState start = run.state();
  const auto height = [&](const HostState& s) {
    double sum = 0;
    for (const Vec3& x : s.node_position) sum += x[1] / static_cast<double>(s.node_position.size());
    return sum;
  };
  run.run_until(3);
  const HostState held = run.state();
  EXPECT_NEAR(height(held), height(start), 1e-3) << "m";
  EXPECT_NEAR(run.body_load(0).attached_force[1], -weight, 0.02 * weight) << "N, on the gripper";
  run.run_until(3.1);
  constexpr double damping = 8, t = 0.1, dt = 0.002;  // 1/s, s: a fall with drag, by steps of implicit Euler
  const double fallen = 9.81 * (t / damping - (1 - std::exp(-damping * t)) / (damping * damping) + 0.5 * dt * t);
  EXPECT_NEAR(height(held) - height(run.state()), fallen, 0.02 * fallen) << "m";
  EXPECT_EQ(run.body_load(0).attached_force[1], 0);
}

TEST(attachments, pins_of_a_scene_and_of_a_program_follow_the_body) {
  Simulation run(scene());
  const HostState start = run.state();
  const std::vector<Index> nodes = upper(start);
  ASSERT_EQ(nodes.size(), 9u);
  run.attach(0, nodes, run.body_named("gripper"));
  EXPECT_EQ(run.attached(0), nodes);
  Simulation held(scene(list_of(nodes)));
  EXPECT_EQ(held.attached(0), nodes);
  const double half = std::numbers::pi / 4;
  for (Simulation* one : {&run, &held}) {
    one->set_body_pose(0, {0.1, 0.2205, 0.05}, {std::cos(half / 2), 0, 0, std::sin(half / 2)}, 0.2);
    one->run_until(0.3);
    EXPECT_LT(off_the_way(one->state(), start, nodes, {0, 0.1205, 0}, {0.1, 0.1, 0.05}, half), 1e-6);
  }
  const HostState a = run.state(), b = held.state();
  double apart = 0;
  for (std::size_t n = 0; n < a.node_position.size(); ++n)
    apart = std::max(apart, (to_eigen(a.node_position[n]) - to_eigen(b.node_position[n])).norm());
  EXPECT_LT(apart, 1e-4);
}

TEST(attachments, a_body_of_the_scene_carries_nodes_along_its_keys) {
  Simulation run(scene());
  run.run_until(0.1);
  const HostState before = run.state();
  run.attach(0, {40}, run.body_named("wheel"));
  run.run_until(0.5);
  EXPECT_LT(off_the_way(run.state(), before, {40}, Vector3d(0.56, 0.55, 0.55), {0.04, 0, 0}, std::numbers::pi / 5),
            2e-6);
}

TEST(attachments, the_body_carries_the_weight_of_what_hangs_on_it) {
  Simulation run(scene());
  run.attach(0, upper(run.state()), 0);
  EXPECT_EQ(run.body_load(0).attached_force, (Vec3{0, 0, 0})) << "before the next step";
  run.run_until(1.5);
  Vec3 force{0, 0, 0}, torque{0, 0, 0};
  constexpr int steps = 50;
  for (int k = 0; k < steps; ++k) {
    run.step();
    const BodyLoad load = run.body_load(0);
    for (std::size_t a = 0; a < 3; ++a) {
      force[a] += load.attached_force[a] / steps;
      torque[a] += load.attached_torque[a] / steps;
    }
  }
  EXPECT_NEAR(force[1], -weight, 0.01 * weight);
  EXPECT_NEAR(force[0], 0, 0.01 * weight);
  EXPECT_NEAR(torque[0], 0, 0.001 * weight);
  EXPECT_NEAR(torque[2], 0, 0.001 * weight);
}

TEST(attachments, detached_nodes_fall) {
  Simulation run(scene());
  const std::vector<Index> nodes = upper(run.state());
  run.attach(0, nodes, 0);
  run.run_until(0.1);
  run.detach(0, nodes);
  EXPECT_TRUE(run.attached(0).empty());
  const double from = run.state().node_position[static_cast<std::size_t>(nodes[4])][1];
  run.run_until(0.3);
  EXPECT_LT(run.state().node_position[static_cast<std::size_t>(nodes[4])][1], from - 0.05);
}

TEST(attachments, continue_bit_for_bit_from_checkpoints_and_states) {
  const TempFolder folder;
  const std::string path = (folder.path() / "attached.drench").string();
  Simulation run(scene());
  const std::vector<Index> nodes = upper(run.state());
  run.attach(0, nodes, 0);
  run.set_body_velocity(0, {0.1, 0.05, 0}, {0, 0.5, 0});
  run.run_until(0.05);
  run.save_checkpoint(path);
  const HostState state = run.state();
  const std::vector<double> changes = run.changes();
  Simulation resumed(scene()), restored(scene());
  resumed.resume(path);
  restored.restore(state, changes);
  EXPECT_EQ(resumed.attached(0), nodes);
  for (Simulation* one : {&run, &resumed, &restored}) {
    one->run_until(0.1);
    one->detach(0, {nodes[0]});
    one->run_until(0.15);
  }
  EXPECT_TRUE(run.state().node_position == resumed.state().node_position);
  EXPECT_TRUE(run.state().node_position == restored.state().node_position);
  run.reset();
  EXPECT_TRUE(run.attached(0).empty());
  run.run_until(0.02);
  Simulation fresh(scene());
  fresh.run_until(0.02);
  EXPECT_TRUE(run.state().node_position == fresh.state().node_position);
}

TEST(attachments, refuse_what_cannot_be_held) {
  Simulation run(scene("    pin: [{nodes: [3]}]\n"));
  const HostState before = run.state();
  EXPECT_THROW(run.attach(0, {3}, 0), std::invalid_argument);   // held by a pin
  EXPECT_THROW(run.attach(0, {81}, 0), std::invalid_argument);  // no such node
  EXPECT_THROW(run.attach(1, {0}, 0), std::invalid_argument);   // no such cloth
  EXPECT_THROW(run.attach(0, {0}, 2), std::invalid_argument);   // no such body
  EXPECT_THROW(run.attach(0, {5, 3}, 0), std::invalid_argument);
  EXPECT_THROW(run.detach(0, {5}), std::invalid_argument);
  EXPECT_TRUE(run.attached(0).empty());
  run.step();
  Simulation other(scene("    pin: [{nodes: [3]}]\n"));
  other.step();
  EXPECT_TRUE(run.state().node_position == other.state().node_position);
  const auto refused = [](const std::string& pin, const std::string& with) {
    try {
      scene(pin);
      ADD_FAILURE() << pin;
    } catch (const SceneError& e) {
      EXPECT_NE(std::string(e.what()).find(with), std::string::npos) << e.what();
    }
  };
  refused("    pin: [{nodes: [3], body: hand}]\n", "no body named 'hand'");
  refused("    pin: [{nodes: [3], body: gripper, velocity: [0, 1, 0]}]\n", "cannot be combined with body");
}

/// A program makes a copy of a run in which nodes are attached: a force on a body acts in it too.
TEST(attachments, do_not_lose_what_acts_on_bodies) {
  const std::string ball =
      "  - sphere: {center: [-0.5, 0, 0], radius: 0.05, dynamic: true, density: 500}\n"
      "fluid: {spacing: 0.02, sources: [{block: {min: [0.7, 0, 0], max: [0.74, 0.04, 0.04]}}]}\n";
  const std::string text = to_yaml(scene());
  const Scene with_ball = parse_scene(text + ball, "attachments.yaml");
  const std::vector<Index> nodes = upper(Simulation(with_ball).state());
  Simulation run(with_ball), copy(with_ball), other_order(with_ball);
  run.attach(0, nodes, 0);
  run.apply_wrench(2, {0, 20, 0}, {0, 0, 1});
  copy.restore(run.state(), run.changes());
  other_order.apply_wrench(2, {0, 20, 0}, {0, 0, 1});
  other_order.attach(0, nodes, 0);
  for (Simulation* any : {&run, &copy, &other_order}) any->run_until(0.02);
  const BodyMotion moved = run.body_motion(2);
  EXPECT_GT(moved.velocity[1], 0.1);
  EXPECT_THROW(run.apply_wrench(2, {0, 1e300, 0}), std::invalid_argument);
  EXPECT_THROW(run.apply_wrench(2, {0, 0, 0}, {1e9, 0, 0}), std::invalid_argument);
  for (const Simulation* any : {&copy, &other_order}) {
    EXPECT_EQ(any->body_motion(2).velocity, moved.velocity);
    EXPECT_EQ(any->body_motion(2).angular_velocity, moved.angular_velocity);
  }
}

}  // namespace
}  // namespace drench::test
