// Stage bodies, and what moving bodies do in the other stages: backend against reference from identical input.

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <numbers>

#include "pipeline/backend.hpp"
#include "stage_compare.hpp"

namespace drench::test {
namespace {

/// A scene with a spinning tetrahedron, written beside the system's other temporary files.
std::string spinning_scene() {
  const auto path = std::filesystem::temp_directory_path() / "drench_bodies_test.obj";
  std::ofstream(path) << "v 0 0 0\nv 0.1 0 0\nv 0 0.1 0\nv 0 0 0.1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n";
  return "drench: 1\ntime: {step: 0.01, end: 1}\nfluid:\n  spacing: 0.02\n  sources:\n    - block: {min: [0.3, 0, 0], "
         "max: [0.4, "
         "0.1, 0.1]}\nbodies:\n  - mesh: {file: " +
         path.string() + ", velocity: [0.1, 0, 0.2], spin: {axis: [0, 1, 1], degrees_per_second: 180}}\n";
}

/// The wet scene whose sphere and floor move, with a spinning box and a moving container besides.
std::string moving_scene() {
  return with(with(wet_scene(), "radius: 0.05}", "radius: 0.05, velocity: [0.3, 0.5, 0], spin: {axis: [0, 0, 1], "
                                                 "degrees_per_second: 400}}"),
              "normal: [0, 1, 0]}", "normal: [0, 1, 0], velocity: [0, 0.4, 0], spin: {axis: [1, 0, 1], "
                                    "degrees_per_second: 40}}\n"
                                    "  - box: {min: [0.02, -0.06, 0.03], max: [0.1, -0.01, 0.1], velocity: [0, 0.3, 0], "
                                    "spin: {axis: [1, 2, 3], degrees_per_second: 200}}\n"
                                    "  - box: {min: [-0.3, -0.3, -0.3], max: [0.3, 0.3, 0.3], inside: true, "
                                    "velocity: [-0.2, 0, 0.1], spin: {axis: [0, 1, 0], degrees_per_second: 30}}");
}

/// Water in a box with a light box and a heavy sphere in it.
std::string floating_scene() {
  return R"(drench: 1
time: {step: 0.002, end: 1.0}
domain: {min: [-1, -1, -1], max: [1, 1, 1]}
output: {every: 0}
fluid:
  spacing: 0.02
  viscosity: 1.0e-3
  solver: {max_iterations: 6, min_iterations: 6}
  sources:
    - block: {min: [-0.15, 0, -0.15], max: [0.15, 0.2, 0.15], velocity: [0.1, 0, 0.05]}
bodies:
  - box: {min: [-0.15, 0, -0.15], max: [0.15, 1, 0.15], inside: true}
  - box: {min: [-0.12, 0.1, -0.05], max: [-0.02, 0.16, 0.06], dynamic: true, density: 300, velocity: [0.1, 0, 0],
          spin: {axis: [1, 1, 3], degrees_per_second: 60}}
  - sphere: {center: [0.07, 0.06, 0], radius: 0.05, dynamic: true, density: 2500}
)";
}

}  // namespace

TEST(bodies, agrees_with_the_reference) {
  compare_stage({.stage = Stage::bodies, .scene = spinning_scene(), .steps_before = 3, .changes = "boundary_position"});
}

TEST(bodies, of_every_kind_move_as_in_the_reference) {
  compare_stage({.stage = Stage::bodies, .scene = moving_scene(), .steps_before = 3, .changes = "body_orientation"});
  compare_stage({.stage = Stage::bodies, .scene = floating_scene(), .changes = "body_orientation"});
}

TEST(bodies, dynamic_bodies_stopped_by_the_container_agree_with_the_reference) {
  compare_stage({.stage = Stage::bodies,
                 .scene = floating_scene(),
                 .prepare =
                     [](const Model&, HostState& s) {
                       s.body_velocity[1] = {-25, 1, 2};  // into the wall at a slant
                       s.body_velocity[2] = {1, -20, -30};
                       s.body_angular_velocity[2] = {3, 0, 0};
                     },
                 .changes = "body_angular_velocity"});
}

TEST(bodies, moving_solids_stop_cloth_and_liquid_as_in_the_reference) {
  compare_stage({.stage = Stage::time_step, .scene = with(moving_scene(), "end: 1.0}", "end: 1.0, mode: cfl}")});
  const auto onto_the_sphere = [](const Model&, HostState& s) {
    for (Vec3& x : s.node_position) x[1] -= 0.0095;
    for (std::size_t i = 0; i < s.fluid_position.size(); i += 7) s.fluid_position[i] = {0.06, -0.03, 0.06};  // in the box
    for (std::size_t i = 3; i < s.fluid_position.size(); i += 7) s.fluid_position[i] = {0.305, -0.1, 0.1};
  };
  compare_stage({.stage = Stage::cloth,
                 .scene = moving_scene(),
                 .prepare = onto_the_sphere,
                 .changes = "node_contact_force"});
  compare_stage({.stage = Stage::pressure,
                 .scene = moving_scene(),
                 .prepare = onto_the_sphere,
                 .changes = "fluid_velocity"});
  compare_stage({.stage = Stage::advection,
                 .scene = moving_scene(),
                 .prepare = onto_the_sphere,
                 .changes = "fluid_velocity"});
}

TEST(bodies, dynamic_bodies_answer_as_in_the_reference) {
  for (const Stage stage : {Stage::density, Stage::divergence, Stage::forces, Stage::pressure}) {
    SCOPED_TRACE(name_of(stage));
    compare_stage({.stage = stage,
                   .scene = floating_scene(),
                   .changes = stage == Stage::density ? "fluid_density_ratio" : "body_angular_velocity"});
  }
}

TEST(bodies, a_moving_wall_pushes_and_a_receding_one_does_not) {
  for (const double speed : {1.0, -1.0}) {
    const auto setup = setup_from(fmt::format(R"(drench: 1
time: {{step: 0.002, end: 1}}
fluid: {{spacing: 0.02, sources: [{{block: {{min: [-0.1, 0.001, -0.1], max: [0.1, 0.021, 0.1]}}}}]}}
bodies: [{{plane: {{point: [0, 0, 0], normal: [0, 1, 0], velocity: [0.5, {}, 0]}}}}]
)",
                                              speed));
    for (const auto& backend : {make_reference_backend(setup.model), make_kokkos_backend(setup.model)}) {
      HostState s = setup.state;
      for (Vec3& x : s.fluid_position) x[1] = 0.001;
      for (Vec3& v : s.fluid_velocity) v = {0, -0.7, 0};
      backend->upload(s);
      StepReport report;
      const StepInfo info{0, 0, 0.002};
      for (const Stage stage : {Stage::neighbors, Stage::density, Stage::advection}) backend->run(stage, info, report);
      const HostState end = backend->download();
      for (std::size_t i = 0; i < end.fluid_position.size(); ++i) {
        if (speed > 0) {  // the surface is at 0.002 by then and moves with 1 m/s
          EXPECT_NEAR(end.fluid_position[i][1], 0.002, 1e-6);
          EXPECT_NEAR(end.fluid_velocity[i][1], 1.0, 1e-5);
        } else {  // it runs away faster than the particle falls
          EXPECT_NEAR(end.fluid_position[i][1], 0.001 - 0.0014, 1e-6);
          EXPECT_NEAR(end.fluid_velocity[i][1], -0.7, 1e-6);
        }
        EXPECT_NEAR(end.fluid_velocity[i][0], 0, 1e-6) << "no friction on liquid in the failsafe";
      }
    }
  }
}

TEST(bodies, prescribed_motion_does_not_drift_over_a_whole_turn) {
  const auto setup = setup_from(spinning_scene());
  const auto backend = make_kokkos_backend(setup.model);
  backend->upload(setup.state);
  StepReport report;
  backend->run(Stage::bodies, {0, 1.99, 0.01}, report);  // t = 2 s: one turn, and 0.2 m and 0.4 m along x and z
  const HostState s = backend->download();
  const Vec3 path{0.2, 0, 0.4};
  for (std::size_t b = 0; b < s.boundary_position.size(); ++b)
    for (std::size_t k = 0; k < 3; ++k)
      EXPECT_NEAR(s.boundary_position[b][k], setup.state.boundary_position[b][k] + path[k], 1e-6);
}

TEST(bodies, a_free_body_keeps_its_angular_momentum_and_its_samples_their_distances) {
  const auto setup = setup_from(floating_scene());
  for (const auto& backend : {make_reference_backend(setup.model), make_kokkos_backend(setup.model)}) {
    HostState s = setup.state;
    s.body_angular_velocity[1] = {3, -20, 8};
    s.body_velocity[1] = {};
    s.body_position[1] = {0, 0.5, 0};  // clear of the walls
    backend->upload(s);
    const Vec3& inertia = setup.model.bodies[1].inertia;
    StepReport report;
    for (int step = 0; step < 200; ++step) backend->run(Stage::bodies, {step, step * 0.002, 0.002}, report);
    const HostState end = backend->download();
    const auto [w, x, y, z] = end.body_orientation[1];
    const double r[3][3] = {{1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)},
                            {2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)},
                            {2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)}};
    double energy[2] = {0, 0};
    for (int a = 0; a < 3; ++a) {
      double momentum = 0, own = 0;
      for (int c = 0; c < 3; ++c) {
        double along = 0;
        for (int k = 0; k < 3; ++k) along += r[k][c] * end.body_angular_velocity[1][k];
        momentum += r[a][c] * inertia[c] * along;
        own += r[c][a] * end.body_angular_velocity[1][c];
      }
      EXPECT_NEAR(momentum, inertia[a] * s.body_angular_velocity[1][a], 1e-9 * inertia[a] * 22);
      energy[0] += inertia[a] * s.body_angular_velocity[1][a] * s.body_angular_velocity[1][a];
      energy[1] += inertia[a] * own * own;
    }
    EXPECT_NEAR(energy[1] / energy[0], 1, 0.02) << "first order in the step";
    const auto apart = [&](const HostState& state) {
      const Body& body = setup.model.bodies[1];
      const Vec3 &p = state.boundary_position[body.first_sample],
                 &q = state.boundary_position[body.first_sample + body.sample_count / 2];
      return std::hypot(p[0] - q[0], p[1] - q[1], p[2] - q[2]);
    };
    EXPECT_NEAR(apart(end), apart(setup.state), 1e-6);
  }
}

}  // namespace drench::test
