// Motion by keys: stage prescribed_motion, and bodies and pins that end each step where their keys say.

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "base/eigen_vec.hpp"
#include "drench/prescribed.hpp"
#include "mesh_sequence.hpp"
#include "pipeline/pipeline.hpp"
#include "precision.hpp"
#include "setup/setup_error.hpp"
#include "stage_compare.hpp"

namespace drench::test {
namespace {

using Eigen::Vector3d;

constexpr double fps = 100;  // of the sequence below

/// Where the box of the sequence is in file k: it wanders and turns about a changing axis.
Vector3d wandering(int k, const Vector3d& corner) {
  const double t = k / fps;
  const Eigen::Quaterniond turn = Eigen::AngleAxisd(3 * t, Vector3d(1, 2, 0.5).normalized()) *
                                  Eigen::AngleAxisd(std::sin(20 * t), Vector3d::UnitZ());
  return Vector3d(0.06 + 0.5 * t, -0.05 + 0.3 * t, 0.06 - t * t) + turn * corner;
}

std::string wandering_box() { return write_boxes("wandering", 12, {0.04, 0.025, 0.03}, wandering); }

/// The wet scene whose sphere and floor move by keys, with a spinning box, and a mesh that follows files.
std::string keyed_scene() {
  return with(
      with(wet_scene(), "radius: 0.05}",
           "radius: 0.05, velocity: {keys: [[0, [0, 0, 0]], [0.0235, [0.3, 0.6, 0]], [0.1, [0, 0, 0]]], interpolation: "
           "smooth}, spin: {axis: [0, 0, 1], degrees_per_second: [[0, 0], [0.03, 900]]}}"),
      "normal: [0, 1, 0]}",
      "normal: [0, 1, 0], offset: {keys: [[0, [0, 0, 0]], [0.03, [0.01, 0.02, 0]], [0.05, [0, 0, 0]]], "
      "interpolation: smooth}, spin: {axis: [1, 0, 1], degrees_per_second: [[0, 0], [0.05, 80]]}}\n"
      "  - box: {min: [-0.1, -0.06, 0.03], max: [-0.02, -0.01, 0.1], offset: [[0, [0, 0, 0]], [0.0241, [0, 0.01, 0]], "
      "[0.1, [0.02, 0, 0]]], spin: {axis: [1, 2, 3], degrees_per_second: {keys: [[0, 100], [0.02, -300]], "
      "interpolation: step}}}\n"
      "  - mesh: {sequence: \"" +
          wandering_box() + "\", fps: 100}");
}

}  // namespace

TEST(prescribed_motion, agrees_with_the_reference) {
  compare_stage({.stage = Stage::prescribed_motion, .scene = keyed_scene(), .changes = "body_velocity"});
  compare_stage({.stage = Stage::prescribed_motion, .scene = keyed_scene(), .changes = "boundary_velocity"});
}

TEST(prescribed_motion, bodies_end_the_step_as_in_the_reference) {
  compare_stage({.stage = Stage::bodies, .scene = keyed_scene(), .changes = "body_orientation"});
  compare_stage({.stage = Stage::bodies, .scene = keyed_scene(), .changes = "boundary_position"});
}

/// A ball and a box that a program moves: the box goes to a pose and is there in the middle of the thirteenth step.
TEST(prescribed_motion, commanded_bodies_move_as_in_the_reference) {
  const std::string scene =
      with(with(wet_scene(), "radius: 0.05}", "radius: 0.05, commanded: true}"), "normal: [0, 1, 0]}",
           "normal: [0, 1, 0]}\n"
           "  - {name: gripper, box: {min: [-0.1, -0.16, 0.03], max: [-0.02, -0.11, 0.1], commanded: true}}");
  const auto command = [](Model& m) {
    Index ball = 0, gripper = 0;
    for (Index b = 0; b < std::ssize(m.bodies); ++b) {
      if (m.bodies[static_cast<std::size_t>(b)].kind == BodyScene::Kind::sphere) ball = b;
      if (m.bodies[static_cast<std::size_t>(b)].name == "gripper") gripper = b;
    }
    const double dt = m.scene.time.step;
    change_body_velocity(m, ball, {0.1, 0.05, -0.1}, {1, 2, -3}, 0);
    change_body_pose(m, gripper, {-0.05, -0.12, 0.06}, {0.9, 0.1, -0.3, 0.2}, 12.5 * dt, 0);
  };
  const std::pair<Stage, const char*> stages[] = {{Stage::prescribed_motion, "body_velocity"},
                                                  {Stage::bodies, "boundary_position"},
                                                  {Stage::pressure, "node_velocity"},
                                                  {Stage::advection, "fluid_position"}};
  for (const auto& [stage, changes] : stages) {
    SCOPED_TRACE(name_of(stage));
    compare_stage({.stage = stage, .scene = scene, .resolve = command, .changes = changes});
  }
}

TEST(prescribed_motion, stops_cloth_and_liquid_as_in_the_reference) {
  const auto onto_the_sphere = [](const Model&, HostState& s) {
    for (Vec3& x : s.node_position) x[1] -= 0.0095;
    for (std::size_t i = 0; i < s.fluid_position.size(); i += 7) s.fluid_position[i] = {0.07, -0.04, 0.06};
  };
  for (const Stage stage : {Stage::cloth, Stage::pressure, Stage::advection})
    compare_stage({.stage = stage,
                   .scene = keyed_scene(),
                   .prepare = onto_the_sphere,
                   .changes = stage == Stage::cloth ? "node_contact_force" : "fluid_velocity"});
}

TEST(prescribed_motion, the_time_step_looks_ahead_along_the_keys) {
  const std::string scene =
      with(wet_scene(), "radius: 0.05}", "radius: 0.05, velocity: [[0.0242, [0, 0, 0]], [0.025, [0, 8, 0]]]}");
  compare_stage({.stage = Stage::time_step, .scene = with(scene, "end: 1.0}", "end: 1.0, mode: cfl}")});
  const auto setup = setup_from(with(scene, "end: 1.0}", "end: 1.0, mode: cfl}"));
  for (const double time : {0.0, 0.0235}) {
    StepReport report;
    const auto backend = make_kokkos_backend(setup.model);
    backend->upload(setup.state);
    backend->run(Stage::time_step, {0, time, 0.002}, report);
    // At 0.0235 s nothing moves fast yet; within the longest step the sphere does.
    if (time > 0) {
      EXPECT_NEAR(report.dt_wanted, 0.4 * 0.02 / 8, 1e-9);
    } else {
      EXPECT_EQ(report.dt_wanted, 0.002);
    }
  }
}

/// Steps of uneven length: all points of the mesh are those of the files at their times. VTK reads 0.1 m to 4e-9 m, in
/// floats.
TEST(keyed_body, follows_its_files_to_rounding) {
  const auto setup = setup_from(keyed_scene());
  const Body& body = setup.model.bodies[3];
  const auto backend = make_kokkos_backend(setup.model);
  Pipeline pipeline(setup.model, *backend, setup.state);
  for (int file = 1; file < 11; ++file) {
    while (pipeline.time() < file / fps - 1e-9) pipeline.step(std::min(0.0013, file / fps - pipeline.time()));
    const HostState s = backend->download();
    const auto& q = s.body_orientation[3];
    for (int c = 0; c < 8; ++c) {
      const Vector3d half(0.04, 0.025, 0.03),
          corner((c & 1 ? 1 : -1) * half[0], (c & 2 ? 1 : -1) * half[1], (c & 4 ? 1 : -1) * half[2]);
      const Vector3d at = to_eigen(s.body_position[3]) +
                          Eigen::Quaterniond(q[0], q[1], q[2], q[3]) * (wandering(0, corner) - to_eigen(body.center));
      EXPECT_LT((at - wandering(file, corner)).norm(), 1e-8) << file << " " << c;
    }
  }
}

/// The wall's velocity over the step takes its samples to where they are at its end.
TEST(keyed_body, the_velocity_of_its_samples_is_their_way_over_the_step) {
  const auto setup = setup_from(keyed_scene());
  const auto backend = make_kokkos_backend(setup.model);
  Pipeline pipeline(setup.model, *backend, setup.state);
  for (int k = 0; k < 12; ++k) pipeline.step(1);
  const StepInfo info{12, pipeline.time(), 0.0005};
  StepReport report;
  const HostState before = backend->download();
  backend->run(Stage::prescribed_motion, info, report);
  const HostState during = backend->download();
  backend->run(Stage::bodies, info, report);
  const HostState after = backend->download();
  const Index first = setup.model.bodies[2].first_sample;
  double worst = 0, fastest = 0;
  for (auto b = static_cast<std::size_t>(first); b < before.boundary_position.size(); ++b)
    for (std::size_t a = 0; a < 3; ++a) {
      const double way = after.boundary_position[b][a] - before.boundary_position[b][a];
      worst = std::max(worst, std::abs(during.boundary_velocity[b][a] * info.dt - way));
      fastest = std::max(fastest, std::abs(way));
    }
  EXPECT_GT(fastest, 2e-4);
  EXPECT_LT(worst, 0.005 * fastest + 2e-8) << "an arc is longer than its chord";
}

TEST(keyed_body, files_with_other_triangles_are_refused) {
  const std::string files =
      write_boxes("other_triangles", 3, {0.04, 0.02, 0.03}, [](int, const Vector3d& x) { return x; });
  std::ofstream(files.substr(0, files.find('{')) + "0001.obj") << "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";
  try {
    setup_from(
        "drench: 1\nfluid: {spacing: 0.02, sources: [{block: {min: [0.2, 0, 0], max: [0.3, 0.1, 0.1]}}]}\n"
        "bodies: [{mesh: {sequence: \"" +
        files + "\"}}]\n");
    FAIL();
  } catch (const SetupError& e) {
    EXPECT_NE(std::string(e.what()).find("box_0001.obj"), std::string::npos) << e.what();
    EXPECT_NE(std::string(e.what()).find("differ from those of the first file"), std::string::npos) << e.what();
  }
}

/// Pins by keys of velocity, offset and spin, in steps of any length.
TEST(keyed_pins, follow_their_keys_to_rounding) {
  const std::string scene = R"(drench: 1
time: {step: 0.004, end: 1}
cloth:
  - mesh: {grid: {size: [0.2, 0.2], nodes: [9, 9]}}
    pin: [{nodes: [0, 8], velocity: {keys: [[0, [0, 0, 0]], [0.05, [1, 0, 0.5]], [0.2, [0, -1, 0]]],
        interpolation: smooth},
           offset: [[0, [0, 0, 0]], [0.1, [0, 0.05, 0]]],
               spin: {axis: [0, 1, 0], degrees_per_second: [[0, 0], [0.2, 300]]}}]
)";
  const auto setup = setup_from(scene);
  const PinScene& pin = setup.model.scene.cloths[0].pins[0];
  for (const double step : {0.004, 0.0027}) {
    const auto backend = make_kokkos_backend(setup.model);
    Pipeline pipeline(setup.model, *backend, setup.state);
    for (int k = 0; k < 60; ++k) {
      pipeline.step(k % 3 == 0 ? 0.7 * step : step);
      const double t = pipeline.time(), angle = pin.spin.degrees_per_second.integral(0, t) * std::numbers::pi / 180;
      const HostState s = backend->download();
      for (const std::size_t n : {0u, 8u}) {
        const Vector3d at = Eigen::AngleAxisd(angle, Vector3d::UnitY()) * to_eigen(setup.state.node_position[n]) +
                            to_eigen(pin.velocity.integral(0, t)) + to_eigen(pin.offset.at(t));
        EXPECT_LT((to_eigen(s.node_position[n]) - at).norm(), double_precision ? 1e-15 : 3e-8) << t << " " << n;
      }
    }
  }
}

/// All nodes pinned to files that bend: each is where its file has it.
TEST(keyed_pins, follow_a_sequence_of_files) {
  const auto bent = [](int k, const Vector3d& x) {
    return Vector3d(x[0] + 0.01 * k, x[1] * (1 + 0.05 * k), x[2] + 0.02 * k * x[0]);
  };
  const std::string files = write_boxes("bending", 5, {0.04, 0.02, 0.03}, bent);
  const std::string first = files.substr(0, files.find('{')) + "0000.obj";
  const auto setup = setup_from("drench: 1\ntime: {step: 0.003, end: 1}\ncloth:\n  - mesh: {file: \"" + first +
                                "\"}\n    place: {position: [0, 0.1, 0], rotate: {axis: [0, 0, 1], degrees: 90}}\n"
                                "    pin: [{box: {min: [-1, -1, -1], max: [1, 1, 1]}, sequence: \"" +
                                files + "\", fps: 50}]\n");
  const auto backend = make_kokkos_backend(setup.model);
  Pipeline pipeline(setup.model, *backend, setup.state);
  for (int file = 1; file < 6; ++file) {
    while (pipeline.time() < file / 50.0 - 1e-9) pipeline.step(file / 50.0 - pipeline.time());
    const HostState s = backend->download();
    for (int c = 0; c < 8; ++c) {
      const Vector3d corner(c & 1 ? 0.04 : -0.04, c & 2 ? 0.02 : -0.02, c & 4 ? 0.03 : -0.03);
      const Vector3d at = Vector3d(0, 0.1, 0) +
                          Eigen::AngleAxisd(std::numbers::pi / 2, Vector3d::UnitZ()) * bent(std::min(file, 4), corner);
      EXPECT_LT((to_eigen(s.node_position[static_cast<std::size_t>(c)]) - at).norm(), double_precision ? 1e-14 : 3e-8);
    }
  }
}

}  // namespace drench::test
