// Liquid at dynamic bodies that others hold: by a floor, a body below, jaws; and in bodies that stop at once.

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "dry_bodies.hpp"
#include "pipeline/pipeline.hpp"

namespace drench::test {
namespace {

constexpr double spacing = 0.01, cup_wall = 0.02, cup_level = 0.08;  // m

/// A cup of `mass` (kg) with 0.5 kg of water, its foot at `height` (m), and other bodies.
std::string cup_with_water(double mass, double height, const std::string& others) {
  return fmt::format(
      "drench: 1\ntime: {{step: 0.002, end: 2}}\ndomain: {{min: [-0.5, -0.5, -0.5], max: [0.5, 0.7, 0.5]}}\n"
      "fluid:\n  spacing: {}\n  viscosity: 1.0e-3\n  sources:\n"
      "    - block: {{min: [-0.04, {}, -0.04], max: [0.04, {}, 0.04]}}\n"
      "bodies:\n  - mesh: {{file: {}, position: [0, {}, 0], dynamic: true, mass: {}, friction: 1}}\n{}",
      spacing, height + cup_wall, height + cup_wall + cup_level, file_of("held_cup.obj", cup_mesh(cup_wall)), height,
      mass, others);
}

const char* const held_floor = "  - plane: {point: [0, 0, 0], normal: [0, 1, 0]}\n";

std::string jaws(const std::string& motion) {
  return "  - box: {min: [-0.1, 0.03, -0.05], max: [-0.0595, 0.1, 0.05], friction: 1" + motion +
         "}\n  - box: {min: [0.0595, 0.03, -0.05], max: [0.1, 0.1, 0.05], friction: 1" + motion + "}\n";
}

}  // namespace

/// A cup of a fiftieth of its water's mass does not yield to it.
TEST(held_bodies, a_light_cup_bears_its_water) {
  struct Case {
    std::string name, others;
    double height;
  };
  for (const Case& c :
       {Case{"on a floor", held_floor, 0},
        Case{"on a block",
             std::string(held_floor) + "  - box: {min: [-0.1, 0, -0.1], max: [0.1, 0.05, 0.1], dynamic: true}\n",
             0.05}}) {
    SCOPED_TRACE(c.name);
    const drench::Setup setup = setup_from(cup_with_water(0.01, c.height, c.others));
    const auto backend = make_kokkos_backend(setup.model);
    Pipeline pipeline(setup.model, *backend, setup.state);
    double pressure = 0, samples = 0, compressed = 0;
    while (pipeline.time() < 0.6) {
      const StepReport report = pipeline.step(1);
      if (pipeline.time() < 0.3) continue;
      compressed = std::max(compressed, report.density_error_max);
      const HostState s = backend->download();
      const double foot = s.body_position[0][1] - setup.model.bodies[0].center[1] + c.height + cup_wall;
      for (std::size_t i = 0; i < s.fluid_position.size(); ++i) {
        const double depth = foot + cup_level - s.fluid_position[i][1];
        if (depth < 0.7 * cup_level) continue;
        pressure += s.fluid_kappa_density[i] / (g * depth);
        samples += 1;
      }
    }
    const HostState end = backend->download();
    EXPECT_NEAR(pressure / samples, 1, 0.1) << "of the hydrostatic pressure, near the foot";
    EXPECT_LT(compressed, 0.08);
    EXPECT_NEAR(end.body_position[0][1], setup.state.body_position[0][1], 0.003);
    EXPECT_TRUE(std::all_of(end.fluid_position.begin(), end.fluid_position.end(),
                            [](const Vec3& x) { return std::abs(x[0]) < 0.045 && std::abs(x[2]) < 0.045; }));
  }
}

TEST(held_bodies, agree_with_the_reference) {
  for (const std::string& others :
       {std::string(held_floor), jaws(", velocity: [0, 0.2, 0]"),
        held_floor + std::string("  - sphere: {center: [0, 0.08, 0], radius: 0.025, dynamic: true, density: 500, "
                                 "restitution: 0.5}\n")})
    for (const Stage stage : {Stage::divergence, Stage::pressure, Stage::advection}) {
      SCOPED_TRACE(others);
      compare_stage({.stage = stage,
                     .scene = cup_with_water(0.05, 0, others),
                     .steps_before = 5,
                     .changes = stage == Stage::advection ? "fluid_position" : "body_velocity"});
    }
}

/// At 3 m/s, with steps of 2 ms, in which particles move by 0.6 spacings.
TEST(held_bodies, a_cup_that_falls_on_a_floor_keeps_its_water) {
  const drench::Setup setup =
      setup_from(cup_with_water(0.2, 0.01, "  - plane: {point: [0, 0, 0], normal: [0, 1, 0]}\n"));
  HostState state = setup.state;
  for (Vec3& v : state.fluid_velocity) v[1] = -3;
  state.body_velocity[0][1] = -3;
  const auto backend = make_kokkos_backend(setup.model);
  Pipeline pipeline(setup.model, *backend, state);
  while (pipeline.time() < 0.1) {
    pipeline.step(1);
    const HostState s = backend->download();
    const auto& q = s.body_orientation[0];
    const Eigen::Quaterniond back = Eigen::Quaterniond(q[0], q[1], q[2], q[3]).conjugate();
    const Eigen::Vector3d center = to_eigen(setup.model.bodies[0].center);
    for (const Vec3& x : s.fluid_position) {
      const Eigen::Vector3d own = back * (to_eigen(x) - to_eigen(s.body_position[0])) + center;
      const double height = own[1] - 0.01, aside = std::max(std::abs(own[0]), std::abs(own[2]));
      EXPECT_GT(height, cup_wall / 2) << "m, above the foot's lower face";
      if (height < 0.09 + cup_wall) {
        EXPECT_LT(aside, 0.04 + cup_wall / 2);
      }
    }
  }
}

/// A block that hits a box of 0.7 and a mesh of 1.2 spacings, by up to 1.8 spacings per step, stays on its side.
TEST(held_bodies, fast_particles_do_not_cross_thin_bodies) {
  const std::string plate = file_of("held_plate.obj", box_mesh({-0.1, -0.006, -0.1}, {0.1, 0.006, 0.1}));
  for (const std::string& body : {std::string("box: {min: [-0.1, 0.0965, -0.1], max: [0.1, 0.1035, 0.1]"),
                                  "mesh: {file: " + plate + ", position: [0, 0.1, 0]"})
    for (const std::string& motion : {std::string("}"), std::string(", velocity: [0, 3, 0]}")}) {
      SCOPED_TRACE(body + motion);
      const std::string scene = fmt::format(
          "drench: 1\ntime: {{step: 0.002, end: 2}}\ndomain: {{min: [-0.5, -0.5, -0.5], max: [0.5, 0.7, 0.5]}}\n"
          "fluid:\n  spacing: {}\n  sources:\n"
          "    - block: {{min: [-0.04, 0.12, -0.04], max: [0.04, 0.16, 0.04], velocity: [0.5, {}, 0.2]}}\n"
          "bodies:\n  - {}{}\n",
          spacing, motion == "}" ? -9 : -6, body, motion);
      compare_stage({.stage = Stage::advection, .scene = scene, .steps_before = 2, .changes = "fluid_position"});
      const drench::Setup setup = setup_from(scene);
      const auto backend = make_kokkos_backend(setup.model);
      Pipeline pipeline(setup.model, *backend, setup.state);
      for (int k = 0; k < 8; ++k) pipeline.step(1);
      const HostState s = backend->download();
      const double face = s.body_position[0][1];
      EXPECT_FALSE(std::any_of(s.fluid_position.begin(), s.fluid_position.end(),
                               [&](const Vec3& x) { return x[1] < face && std::abs(x[0]) < 0.09; }));
    }
}

}  // namespace drench::test
