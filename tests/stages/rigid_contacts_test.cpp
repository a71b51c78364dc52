// Contacts of dynamic bodies with each other and with solids, and dynamic meshes: against the laws of mechanics.

#include "state/rigid_contacts.hpp"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <fstream>
#include <numbers>

#include "ball_mesh.hpp"
#include "base/eigen_vec.hpp"
#include "dry_bodies.hpp"
#include "paths.hpp"
#include "pipeline/pipeline.hpp"
#include "stage_compare.hpp"

namespace drench::test {
namespace {

using Eigen::Vector3d;

const char* const floor_plane = "  - plane: {point: [0, 0, 0], normal: [0, 1, 0]}\n";

}  // namespace

TEST(rigid_contacts, bodies_of_every_kind_come_to_rest_on_a_floor) {
  const std::string box = file_of("rest_box.obj", box_mesh({-0.05, -0.03, -0.04}, {0.05, 0.03, 0.04})),
                    ball = file_of("rest_ball.obj", ball_mesh(3)), cup = file_of("rest_cup.obj", cup_mesh());
  struct Case {
    std::string body;
    double height;  // m: of the centre at rest
  };
  const std::vector<Case> cases{
      {"box: {min: [-0.05, 0.005, -0.04], max: [0.05, 0.065, 0.04], dynamic: true}", 0.03},
      {"sphere: {center: [0, 0.055, 0], radius: 0.05, dynamic: true}", 0.05},
      {"mesh: {file: " + box + ", position: [0, 0.035, 0], dynamic: true}", 0.03},
      {"mesh: {file: " + ball + ", scale: 0.05, position: [0, 0.055, 0], dynamic: true}", 0.05},
      {"mesh: {file: " + cup + ", position: [0, 0.005, 0], dynamic: true}", 0}};
  for (const Case& c : cases) {
    SCOPED_TRACE(c.body);
    Dry dry(floor_plane + ("  - " + c.body + "\n"));
    const double height = c.height > 0 ? c.height : dry.at(1)[1] - 0.005;
    dry.run(0.6);
    EXPECT_NEAR(dry.at(1)[1], height, 0.0005);
    if (c.body.find("scale") == std::string::npos) {  // the ball of triangles stands on a corner and tips over
      EXPECT_NEAR(std::hypot(dry.at(1)[0], dry.at(1)[2]), 0, 0.0005);
      EXPECT_LT(dry.velocity(1).norm(), 0.002);
      EXPECT_LT(dry.turned(1), 0.5);
    }
    double weight = 0;
    for (int k = 0; k < 50; ++k) {
      dry.step();
      weight -= dry.given[0].impulse[1] / (50 * dt);
    }
    EXPECT_NEAR(weight, dry.setup.model.bodies[1].mass * g, 0.01 * weight);
  }
}

TEST(rigid_contacts, a_box_slides_down_a_slope_by_coulombs_law) {
  const std::string mesh = file_of("slide_box.obj", box_mesh({-0.05, -0.03, -0.04}, {0.05, 0.03, 0.04}));
  for (const std::string& box :
       {std::string("box: {min: [-0.05, 0, -0.04], max: [0.05, 0.06, 0.04], dynamic: true, friction: 0.3}"),
        "mesh: {file: " + mesh + ", position: [0, 0.03, 0], dynamic: true, friction: 0.3}"})
    for (const double slope : {12.0, 30.0}) {  // degrees; it begins to slide at 16.7
      const double a = slope * std::numbers::pi / 180, mu = 0.3;
      SCOPED_TRACE(fmt::format("{} at {} degrees", box, slope));
      // The slope turns, not the box: gravity gets a component along the floor.
      Dry dry("  - plane: {point: [0, 0, 0], normal: [0, 1, 0], friction: 0.3}\n  - " + box + "\n");
      constexpr int steps = 200;
      for (int k = 0; k < steps; ++k) {
        dry.motion[1].velocity[0] += dt * g * std::sin(a);
        dry.motion[1].velocity[1] += dt * g * (1 - std::cos(a));
        dry.step();
      }
      const double slides = std::max(0.0, g * (std::sin(a) - mu * std::cos(a)));
      EXPECT_NEAR(dry.velocity(1)[0], slides * steps * dt, 0.02 * g * steps * dt);
      EXPECT_LT(dry.turned(1), 1);
    }
}

TEST(rigid_contacts, balls_exchange_momentum) {
  for (const double e : {0.0, 1.0}) {
    SCOPED_TRACE(e);
    Dry dry(fmt::format(
        "  - sphere: {{center: [-0.2, 0, 0], radius: 0.05, dynamic: true, density: 1000, velocity: [1, 0, 0], "
        "restitution: {0}}}\n"
        "  - sphere: {{center: [0.2, 0, 0], radius: 0.04, dynamic: true, density: 3000, restitution: {0}}}\n",
        e));
    const double m1 = dry.setup.model.bodies[0].mass, m2 = dry.setup.model.bodies[1].mass;
    for (int k = 0; k < 300; ++k) {
      for (auto& m : dry.motion) m.velocity[1] = g * dt;  // no gravity
      dry.step();
    }
    const double together = m1 / (m1 + m2);
    EXPECT_NEAR(m1 * dry.velocity(0)[0] + m2 * dry.velocity(1)[0], m1, 1e-6 * m1);
    EXPECT_NEAR(dry.velocity(0)[0], e > 0 ? (m1 - m2) / (m1 + m2) : together, 0.01);
    EXPECT_NEAR(dry.velocity(1)[0], e > 0 ? 2 * m1 / (m1 + m2) : together, 0.01);
  }
}

TEST(rigid_contacts, bodies_bounce_by_their_restitution_whatever_they_overlap) {
  const std::string cup = file_of("bounce_cup.obj", cup_mesh());
  const std::vector<std::string> bodies = {
      "sphere: {{center: [0, {0}, 0], radius: 0.05, dynamic: true, restitution: {1}}}",
      "box: {{min: [-0.05, {0}, -0.04], max: [0.05, {2}, 0.04], dynamic: true, restitution: {1}}}",
      "mesh: {{file: " + cup + ", position: [0, {0}, 0], dynamic: true, restitution: {1}}}"};
  for (const std::string& body : bodies)
    for (const double e : {0.0, 0.5, 1.0})
      for (const double height : {0.2, 0.2037, 0.2071, 0.35}) {  // it meets the floor at other parts of a step
        SCOPED_TRACE(fmt::format("{} {} {}", body, e, height));
        Dry dry(fmt::format("  - plane: {{point: [0, 0, 0], normal: [0, 1, 0], restitution: {}}}\n  - ", e) +
                fmt::format(fmt::runtime(body), height, e, height + 0.06) + "\n");
        double hit = 0, left = 0;
        for (int k = 0; k < 200; ++k) {
          dry.step();
          hit = std::max(hit, -dry.velocity(1)[1]);
          left = std::max(left, dry.velocity(1)[1]);
        }
        EXPECT_NEAR(left, e * hit, 0.02 * hit);
      }
}

TEST(rigid_contacts, a_stack_stands_and_a_cup_holds_a_ball_that_it_carries) {
  const std::string box = file_of("stack_box.obj", box_mesh({-0.05, -0.03, -0.04}, {0.05, 0.03, 0.04})),
                    cup = file_of("carry_cup.obj", cup_mesh());
  Dry stack(floor_plane +
            fmt::format("  - mesh: {{file: {}, position: [0, 0.03, 0], dynamic: true}}\n"
                        "  - box: {{min: [-0.04, 0.06, -0.03], max: [0.04, 0.1, 0.03], dynamic: true, density: 900}}\n",
                        box));
  stack.run(1);
  EXPECT_NEAR(stack.at(1)[1], 0.03, 0.001);
  EXPECT_NEAR(stack.at(2)[1], 0.08, 0.002);
  EXPECT_LT(stack.turned(2), 1);
  Dry carried(
      fmt::format("  - mesh: {{file: {}, velocity: [0.5, 0.3, 0]}}\n"
                  "  - sphere: {{center: [0, 0.03, 0], radius: 0.02, dynamic: true, velocity: [0.5, 0.3, 0]}}\n",
                  cup));
  carried.run(0.8);
  const Vector3d inside = carried.at(1) - carried.at(0);  // of the cup's middle
  EXPECT_NEAR(carried.at(0)[0], 0.4, 0.01);
  EXPECT_LT(std::max(std::abs(inside[0]), std::abs(inside[2])), 0.021);
  EXPECT_NEAR(inside[1], -0.02, 0.002);
}

TEST(rigid_contacts, two_grippers_lift_a_box_by_friction) {
  Dry dry(floor_plane +
          std::string("  - box: {min: [-0.03, 0, -0.03], max: [0.03, 0.06, 0.03], dynamic: true, friction: 0.9}\n"
                      "  - box: {min: [-0.1, 0.02, -0.05], max: [-0.05, 0.05, 0.05], friction: 0.9}\n"
                      "  - box: {min: [0.05, 0.02, -0.05], max: [0.1, 0.05, 0.05], friction: 0.9}\n"));
  for (int k = 0; k < 400; ++k) {  // they close, press 0.5 mm into it, and rise by 0.1 m
    const double closing = k < 50 ? 0.2 : k < 100 ? 0.005 : 0, rising = k >= 150 ? 0.2 : 0;
    dry.motion[2].velocity = {closing, rising, 0};
    dry.motion[3].velocity = {-closing, rising, 0};
    dry.step();
  }
  EXPECT_NEAR(dry.at(1)[1], 0.13, 0.002);
  EXPECT_NEAR(dry.at(1)[0], 0, 0.0005);
  EXPECT_LT(dry.turned(1), 3);  // it may turn about the line between them
}

TEST(rigid_contacts, a_fast_ball_does_not_pass_a_thin_wall) {
  Dry dry(
      "  - box: {min: [-0.5, -0.005, -0.5], max: [0.5, 0, 0.5]}\n"
      "  - sphere: {center: [0, 0.3, 0], radius: 0.02, dynamic: true, velocity: [0, -60, 0]}\n");
  dry.run(0.1);
  EXPECT_NEAR(dry.at(1)[1], 0.02, 0.002);
}

TEST(rigid_contacts, keep_nothing_from_step_to_step) {
  const std::string cup = file_of("bits_cup.obj", cup_mesh());
  Dry dry(floor_plane +
          fmt::format("  - mesh: {{file: {}, position: [0, 0.05, 0], dynamic: true, spin: {{axis: [1, 0, 1], "
                      "degrees_per_second: 300}}}}\n"
                      "  - sphere: {{center: [0, 0.12, 0], radius: 0.02, dynamic: true}}\n"
                      "  - name: door\n    box: {{min: [0.2, 0.5, -0.1], max: [0.5, 0.53, 0.1], dynamic: true}}\n"
                      "joints:\n  - hinge: {{body: door, point: [0.2, 0.5, 0], axis: [0, 0, 1], limits: [-40, 10], "
                      "motor: {{torque: 0.1}}}}\n",
                      cup));
  dry.run(0.2);
  RigidContacts fresh(dry.setup.model);
  for (int k = 0; k < 20; ++k) {
    std::vector<RigidMotion> again = dry.motion;
    for (std::size_t b = 1; b < again.size(); ++b) again[b].velocity[1] -= g * dt;
    std::vector<RigidMotion> first = again;
    fresh.advance(again, dt, dry.time + dt);
    dry.contacts.advance(first, dt, dry.time + dt);
    for (std::size_t b = 0; b < again.size(); ++b) {
      EXPECT_EQ(again[b].position, first[b].position);
      EXPECT_EQ(again[b].velocity, first[b].velocity);
      EXPECT_EQ(again[b].orientation, first[b].orientation);
    }
    dry.step();
  }
}

TEST(rigid_contacts, a_mesh_has_the_mass_and_the_inertia_of_the_solid_that_it_bounds) {
  const Eigen::AngleAxisd turn(0.7, Vector3d(1, 2, 3).normalized());
  TestMesh mesh = box_mesh({-0.05, -0.03, -0.02}, {0.05, 0.03, 0.02});
  for (Vector3d& x : mesh.points) x = turn * x + Vector3d(0.3, 0.1, 0.2);
  const Body body =
      setup_from(scene_of("  - mesh: {file: " + file_of("heavy_box.obj", mesh) + ", dynamic: true, density: 2000}\n"))
          .model.bodies[0];
  const double mass = 2000 * 0.1 * 0.06 * 0.04;
  EXPECT_NEAR(body.mass, mass, 1e-9 * mass);
  EXPECT_LT((to_eigen(body.center) - Vector3d(0.3, 0.1, 0.2)).norm(), 1e-12);
  const Eigen::Quaterniond principal(body.principal[0], body.principal[1], body.principal[2], body.principal[3]);
  const Eigen::Matrix3d axes = principal.toRotationMatrix(),
                        inertia = axes * to_eigen(body.inertia).asDiagonal() * axes.transpose();
  const Vector3d own =
      mass / 12 * Vector3d(0.06 * 0.06 + 0.04 * 0.04, 0.1 * 0.1 + 0.04 * 0.04, 0.1 * 0.1 + 0.06 * 0.06);
  const Eigen::Matrix3d whole = turn.toRotationMatrix() * own.asDiagonal() * turn.toRotationMatrix().transpose();
  EXPECT_LT((inertia - whole).norm(), 1e-9 * whole.norm());
  const Body light =
      setup_from(scene_of("  - mesh: {file: " + file_of("heavy_box.obj", mesh) + ", dynamic: true, mass: 0.1}\n"))
          .model.bodies[0];
  EXPECT_NEAR(light.mass, 0.1, 1e-12);
  EXPECT_LT((to_eigen(light.inertia) - 0.1 / mass * to_eigen(body.inertia)).norm(), 1e-9 * light.inertia[0]);
}

/// In a pool, on both backends, with a cup and a container.
TEST(rigid_contacts, dynamic_meshes_agree_with_the_reference) {
  const std::string scene = R"(drench: 1
time: {step: 0.002, end: 1}
domain: {min: [-0.5, -0.5, -0.5], max: [0.5, 0.5, 0.5]}
fluid:
  spacing: 0.02
  sources:
    - block: {min: [-0.15, 0, -0.15], max: [0.15, 0.1, 0.15]}
bodies:
  - box: {min: [-0.15, 0, -0.15], max: [0.15, 1, 0.15], inside: true}
  - mesh: {file: )" + file_of("pool_cup.obj", cup_mesh()) +
                            R"(, position: [0.02, 0.1, 0.01], dynamic: true, density: 400, velocity: [0, -0.5, 0],
           spin: {axis: [1, 1, 3], degrees_per_second: 60}}
  - sphere: {center: [0.02, 0.14, 0.01], radius: 0.025, dynamic: true, density: 2500}
)";
  compare_stage({.stage = Stage::bodies, .scene = scene, .steps_before = 10, .changes = "body_orientation"});
  compare_stage({.stage = Stage::pressure, .scene = scene, .steps_before = 10, .changes = "body_angular_velocity"});
}

/// A ball of triangles floats as a sphere does.
TEST(rigid_contacts, a_mesh_ball_floats_as_a_sphere) {
  double height[2];
  const std::string ball = file_of("float_ball.obj", ball_mesh(3));
  for (const int mesh : {0, 1}) {
    const std::string body =
        mesh ? "mesh: {file: " + ball + ", scale: 0.08, position: [0, 0.2, 0], dynamic: true, density: 500}"
             : "sphere: {center: [0, 0.2, 0], radius: 0.08, dynamic: true, density: 500}";
    const auto setup = setup_from(
        "drench: 1\ntime: {step: 0.004, end: 1}\ndomain: {min: [-0.5, -0.5, -0.5], max: [0.5, 0.5, 0.5]}\n"
        "fluid:\n  spacing: 0.025\n  viscosity: 0.01\n  sources:\n    - block: {min: [-0.16, 0, -0.16], max: [0.16, "
        "0.2, 0.16]}\n"
        "bodies:\n  - box: {min: [-0.16, 0, -0.16], max: [0.16, 1, 0.16], inside: true}\n  - " +
        body + "\n");
    const auto backend = make_kokkos_backend(setup.model);
    Pipeline pipeline(setup.model, *backend, setup.state);
    double sum = 0;
    for (int k = 0; k < 75; ++k) {
      pipeline.step(1.0);
      if (k >= 50) sum += backend->download().body_position[1][1] / 25;
    }
    height[mesh] = sum;
  }
  EXPECT_NEAR(height[1], height[0], 0.005);  // a fifth of a spacing
}

}  // namespace drench::test
