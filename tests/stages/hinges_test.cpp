// Hinges, their stops and motors: against the laws of mechanics, against the reference, and with water on them.

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "dry_bodies.hpp"
#include "pipeline/pipeline.hpp"

namespace drench::test {
namespace {

using Eigen::Vector3d;

/// A basin of 0.3 m whose water a gate holds back; `gate`: keys of the gate, `hinge`: of its hinge.
std::string gated(const std::string& gate, const std::string& hinge) {
  return "drench: 1\ntime: {step: 0.002, end: 2}\ndomain: {min: [-0.5, -0.5, -0.5], max: [0.5, 0.7, 0.5]}\n"
         "fluid:\n  spacing: 0.025\n  viscosity: 1.0e-3\n  sources:\n"
         "    - block: {min: [0.04, 0, -0.1], max: [0.3, 0.25, 0.1]}\n"
         "bodies:\n  - box: {min: [-0.3, 0, -0.1], max: [0.3, 0.6, 0.1], inside: true}\n"
         "  - name: gate\n    box: {min: [0, 0.005, -0.095], max: [0.04, 0.4, 0.095], dynamic: true, " +
         gate +
         "}\n  - name: hand\n    box: {min: [0, 0.45, -0.05], max: [0.05, 0.5, 0.05], velocity: [0.2, 0, 0], "
         "spin: {axis: [0, 0, 1], degrees_per_second: 40}}\n"
         "joints:\n  - hinge: {body: gate, axis: [0, 0, 1], " +
         hinge + "}\n";
}

}  // namespace

TEST(hinges, a_hinged_bar_swings_as_a_physical_pendulum) {
  const double length = 0.4, width = 0.04, arm = length / 2;
  for (const std::string& to : {std::string(), std::string(", to: frame")}) {
    Dry dry(
        "  - name: bar\n    box: {min: [-0.02, 0.6, -0.02], max: [0.02, 1, 0.02], dynamic: true, "
        "velocity: [0.1, 0, 0], spin: {axis: [0, 0, 1], degrees_per_second: 28.6479}}\n"
        "  - name: frame\n    box: {min: [-0.1, 1.05, -0.1], max: [0.1, 1.1, 0.1]}\n"
        "joints:\n  - hinge: {body: bar, point: [0, 1, 0], axis: [0, 0, 1]" +
        to + "}\n");
    const double turning = (length * length + width * width) / 12 + arm * arm,
                 period = 2 * std::numbers::pi * std::sqrt(turning / (g * arm));
    int crossings = 0;
    double last = 0, farthest = 0;
    while (crossings < 10 && dry.time < 20) {
      const double before = dry.at(0)[0];
      dry.step();
      const double after = dry.at(0)[0];
      if ((before < 0) != (after < 0)) {
        ++crossings;
        last = dry.time - dt * after / (after - before);
      }
      const Vector3d up = Eigen::Quaterniond(dry.motion[0].orientation[0], dry.motion[0].orientation[1],
                                             dry.motion[0].orientation[2], dry.motion[0].orientation[3]) *
                          Vector3d(0, arm, 0);
      farthest = std::max(farthest, (dry.at(0) + up - Vector3d(0, 1, 0)).norm());
    }
    EXPECT_NEAR(last, 5 * period, 0.01 * 5 * period);
    EXPECT_LT(farthest, 1e-4) << "m, from its axis";
    EXPECT_NEAR(dry.velocity(0).norm(), 0.1, 0.005) << "m/s, at the lowest point after five periods";
    double weight = 0;
    for (int k = 0; k < 1000; ++k) {
      dry.step();
      weight += dry.given[0].impulse[1] / (1000 * dt);
    }
    EXPECT_NEAR(weight, dry.setup.model.bodies[0].mass * g, 0.02 * weight);
    EXPECT_NEAR(dry.given[1].impulse[1], to.empty() ? 0 : -dry.given[0].impulse[1], 1e-9);
  }
}

TEST(hinges, a_motor_turns_a_wheel_at_its_speed_or_with_its_torque) {
  const auto wheel = [](const std::string& motor) {
    return "  - name: wheel\n    sphere: {center: [0, 1, 0], radius: 0.1, dynamic: true, mass: 2}\n"
           "joints:\n  - hinge: {body: wheel, point: [0, 1, 0], axis: [0, 0, 2], " +
           motor + "}\n";
  };
  const double inertia = 0.4 * 2 * 0.01;
  Dry steady(wheel("motor: {degrees_per_second: [[0, 0], [1, 180], [2, 180]], torque: 5}"));
  steady.run(0.5);
  EXPECT_NEAR(steady.motion[0].spin[2], std::numbers::pi / 2, 0.01);
  steady.run(1);
  EXPECT_NEAR(steady.motion[0].spin[2], std::numbers::pi, 1e-3);
  EXPECT_NEAR((steady.at(0) - Vector3d(0, 1, 0)).norm(), 0, 1e-4) << "m: the hinge carries its weight";
  Dry weak(wheel("motor: {degrees_per_second: -1800, torque: 0.02}"));
  weak.run(0.4);
  EXPECT_NEAR(weak.motion[0].spin[2], -0.02 * weak.time / inertia, 0.01);
  EXPECT_NEAR(weak.given[0].turning[2], -0.02 * dt, 1e-6 * dt);
}

TEST(hinges, a_hinge_stops_at_its_limits) {
  Dry dry(
      "  - name: door\n    box: {min: [0, 0.99, -0.1], max: [0.3, 1.01, 0.1], dynamic: true}\n"
      "joints:\n  - hinge: {body: door, point: [0, 1, 0], axis: [0, 0, 1], limits: [-40, 10]}\n");
  dry.run(2);
  const double angle = std::asin((dry.at(0)[1] - 1) / 0.15) * 180 / std::numbers::pi;
  EXPECT_NEAR(angle, -40, 0.5);
  EXPECT_LT(dry.velocity(0).norm(), 0.01);
}

/// The joint is exact on a body that turns across the axis, and hands it the whole torque.
TEST(hinges, a_hinge_follows_a_body_that_turns_across_its_axis) {
  Dry dry(
      "  - name: lid\n    box: {min: [0, 0.99, -0.1], max: [0.3, 1.01, 0.1], dynamic: true}\n"
      "  - name: hand\n    box: {min: [-0.3, 0.9, -0.1], max: [-0.1, 1.1, 0.1]}\n"
      "joints:\n  - hinge: {body: lid, to: hand, point: [0, 1, 0], axis: [0, 0, 1], limits: [-5, 5]}\n");
  const auto turned = [&](std::size_t b, const Vector3d& v) {
    const auto& q = dry.motion[b].orientation;
    return Vector3d(Eigen::Quaterniond(q[0], q[1], q[2], q[3]) * v);
  };
  double farthest = 0, torque = 0;
  for (int k = 0; k < 500; ++k) {
    const double angle = 1.0 * dry.time;  // rad, about x
    dry.motion[1].spin = {1, 0, 0};
    dry.motion[1].orientation = {std::cos(angle / 2), std::sin(angle / 2), 0, 0};
    dry.step();
    const Vector3d own = dry.at(0) + turned(0, {-0.15, 0, 0});
    dry.motion[1].orientation = {std::cos((angle + dt) / 2), std::sin((angle + dt) / 2), 0, 0};
    farthest = std::max(farthest, (own - dry.at(1) - turned(1, {0.2, 0, 0})).norm());
    if (k < 5) torque += dry.given[1].turning[2] / (5 * dt);
  }
  EXPECT_LT(farthest, 5e-4) << "m, from its axis";
  Dry still(
      "  - name: lid\n    box: {min: [0, 0.99, -0.1], max: [0.3, 1.01, 0.1], dynamic: true}\n"
      "  - name: hand\n    box: {min: [-0.3, 0.9, -0.1], max: [-0.1, 1.1, 0.1]}\n"
      "joints:\n  - hinge: {body: lid, to: hand, point: [0, 1, 0], axis: [0, 0, 1], limits: [-5, 5]}\n");
  still.run(1);
  const double weight = still.setup.model.bodies[0].mass * g;
  double held = 0;
  for (int k = 0; k < 100; ++k) {
    still.step();
    held += still.given[1].turning[2] / (100 * dt);
  }
  EXPECT_NEAR(held, -0.35 * weight, 0.02 * 0.35 * weight) << "N m: the lid's weight at its distance from the hand";
}

/// Too weak for the lid, a motor does not lift it from its stop.
TEST(hinges, a_weak_motor_leaves_a_lid_on_its_stop) {
  for (const double torque : {0.2, 5.0}) {
    Dry dry(
        fmt::format("  - name: lid\n    box: {{min: [0, 0.99, -0.1], max: [0.3, 1.01, 0.1], dynamic: true}}\n"
                    "joints:\n  - hinge: {{body: lid, point: [0, 1, 0], axis: [0, 0, 1], limits: [0, 90], motor: "
                    "{{degrees_per_second: 60, torque: {}}}}}\n",
                    torque));
    const double needed = dry.setup.model.bodies[0].mass * g * 0.15;
    ASSERT_LT(0.2, needed);
    ASSERT_GT(5.0, needed);
    dry.run(1);
    EXPECT_NEAR(dry.turned(0), torque < needed ? 0 : 60, 1);
  }
}

TEST(hinges, hinged_bodies_agree_with_the_reference) {
  const std::string moving =
      "density: 300, spin: {axis: [0, 0, 1], degrees_per_second: 40}, velocity: [0.1, -0.1, 0.2]";
  for (const std::string& hinge :
       {std::string("point: [0.02, 0.39, 0]"), std::string("point: [0.02, 0.39, 0], limits: [0, 60]"),
        std::string("point: [0.02, 0.39, 0.05], motor: {degrees_per_second: [[0, 0], [1, 90]], torque: 0.3}"),
        std::string("to: hand, point: [0.02, 0.42, 0], limits: [-5, 5]")})
    for (const Stage stage : {Stage::divergence, Stage::pressure, Stage::bodies}) {
      SCOPED_TRACE(hinge);
      compare_stage({.stage = stage,
                     .scene = gated(moving, hinge),
                     .steps_before = 6,
                     .changes = stage == Stage::bodies ? "body_orientation" : "body_angular_velocity"});
    }
}

/// A gate that its stop keeps shut holds the water's whole pressure, be it ever so light.
TEST(hinges, a_shut_gate_holds_its_water_back) {
  struct Case {
    double density;
    std::string hinges;
  };
  const std::string one = "point: [0.02, 0.39, -0.05], limits: [0, 60]";
  for (const auto& [density, hinges] :
       {Case{1000, one}, Case{50, one},
        Case{50, one + "}\n  - hinge: {body: gate, axis: [0, 0, 1], point: [0.02, 0.39, 0.05]"}}) {
    SCOPED_TRACE(hinges);
    const drench::Setup setup = setup_from(gated(fmt::format("density: {}", density), hinges));
    const auto backend = make_kokkos_backend(setup.model);
    Pipeline pipeline(setup.model, *backend, setup.state);
    double pressure = 0, samples = 0;
    while (pipeline.time() < 1.2) {
      pipeline.step(1);
      if (pipeline.time() < 0.7) continue;
      const HostState s = backend->download();
      for (std::size_t i = 0; i < s.fluid_position.size(); ++i) {
        const Vec3& x = s.fluid_position[i];
        if (x[1] > 0.08 || x[0] > 0.12) continue;
        pressure +=
            setup.model.rest_density * s.fluid_kappa_density[i] / (setup.model.rest_density * g * (0.25 - x[1]));
        samples += 1;
      }
    }
    const HostState end = backend->download();
    const auto leaked =
        std::count_if(end.fluid_position.begin(), end.fluid_position.end(), [](const Vec3& x) { return x[0] < 0; });
    EXPECT_NEAR(pressure / samples, 1, 0.1)
        << "of the hydrostatic pressure, at the foot of a gate of density " << density;
    EXPECT_LT(static_cast<double>(leaked), 0.01 * static_cast<double>(end.fluid_position.size()));
  }
}

}  // namespace drench::test
