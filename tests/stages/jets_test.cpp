// Stage jets: backend against reference from identical input.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstring>

#include "ball_mesh.hpp"
#include "drench/prescribed.hpp"
#include "point_caches.hpp"
#include "quanta_sum.hpp"
#include "stage_compare.hpp"
#include "state/nozzle.hpp"

namespace drench::test {
namespace {

constexpr const char* disc = "radius: 0.025, velocity: [0, -1.5, 0.1]}";
constexpr const char* motion =
    "motion: {velocity: {keys: [[0, [0, 0, 0]], [0.015, [2, 0, -1]]], interpolation: smooth}, "
    "offset: [[0, [0, 0, 0]], [0.02, [0, 0.02, 0]], [0.03, [0.05, 0, 0]]], "
    "spin: {axis: [1, 2, 0], degrees_per_second: [[0, 300], [0.02, 900]], center: [0, 0.3, 0.1]}}}";

/// The wet scene with another mouth for its jet.
std::string with_mouth(const std::string& mouth) { return with(wet_scene(), disc, mouth); }

/// A point of the ball in file k.
Eigen::Vector3d point_of_ball(int k, const Eigen::Vector3d& x) {
  const Eigen::AngleAxisd turn(0.4 * k, Eigen::Vector3d(1, 1, 0).normalized());
  return (0.05 + 0.01 * k) * (turn * x) + Eigen::Vector3d(0.01 * k * k, 0.3, 0.1);
}
/// Its area, m², where the points go straight from file to file.
double area_of_ball(double file) {
  const int k = std::min(static_cast<int>(file), 2);
  TestMesh ball = ball_mesh(0);
  for (Eigen::Vector3d& x : ball.points) {
    const Eigen::Vector3d from = point_of_ball(k, x);
    x = from + (file - k) * (point_of_ball(k + 1, x) - from);
  }
  double area = 0;
  for (const auto& t : ball.triangles) {
    const auto corner = [&](int c) { return ball.points[static_cast<std::size_t>(t[static_cast<std::size_t>(c)])]; };
    area += 0.5 * (corner(1) - corner(0)).cross(corner(2) - corner(0)).norm();
  }
  return area;
}

/// And with an emitter of mesh files, a ball of 8 faces that grows, turns and moves.
std::string with_ball(const std::string& keys) {
  const std::string files = write_shapes("emitting_ball", 4, ball_mesh(0), point_of_ball);
  const auto named =
      keys.find("sequence") == std::string::npos ? files.substr(0, files.rfind('/')) + "/0000.obj" : files;
  return with(wet_scene(), "    - jet:", "    - mesh_jet: {" + with(keys, "FILES", named) + "}\n    - jet:");
}

/// Jets alone for a while, with steps of this length; liquid goes straight on between them.
HostState flow_on(const Model& model, HostState state, Backend& backend, double dt, int steps) {
  state.fluid_position.clear();
  for (int k = 0; k < steps; ++k) {
    for (std::size_t i = 0; i < state.fluid_position.size(); ++i)
      for (std::size_t a = 0; a < 3; ++a) state.fluid_position[i][a] += dt * state.fluid_velocity[i][a];
    backend.upload(state);
    StepReport report;
    backend.run(Stage::jets, {k, k * dt, dt}, report);
    state = backend.download();
  }
  EXPECT_EQ(state.supplied, sum(state.fluid_mass)) << model.scene.path;
  return state;
}

}  // namespace

TEST(jets, agrees_with_the_reference) {
  compare_stage({.stage = Stage::jets, .steps_before = 11, .changes = "fluid_position"});
}

TEST(jets, that_a_program_changes_agree_with_the_reference) {
  compare_stage({.stage = Stage::jets,
                 .steps_before = 11,
                 .resolve =
                     [](Model& model) {
                       change_jet(model, 0, {0.4, -1.7, 0.2}, Vec3{0.01, 0.3, 0}, 0.01);
                     },
                 .changes = "fluid_position"});
}

TEST(jets, of_sprays_agree_with_the_reference) {
  for (const std::string keys :
       {"half_angle: 25, speed: 3, flow: 5}", "half_angle: 180, speed: 2, flow: 120, start: 0.003, end: 0.03}",
        "half_angle: 0, speed: 4, flow: 30}"})
    compare_stage(
        {.stage = Stage::jets,
         .scene = with(wet_scene(), "sources:\n",
                       "sources:\n    - spray: {center: [0.02, 0.3, 0.1], direction: [1, -2, 0.5], " + keys + "\n"),
         .steps_before = 11,
         .changes = "fluid_position"});
  compare_stage({.stage = Stage::jets,
                 .scene = with(wet_scene(), "sources:\n",
                               "sources:\n    - spray: {center: [0, 0.3, 0.1], direction: [0, -1, 0], half_angle: 60, "
                               "speed: 2, flow: 60, " +
                                   std::string(motion) + "\n"),
                 .steps_before = 11,
                 .changes = "fluid_position"});
}

/// Drops fly freely here, so that each keeps the velocity with which it left.
TEST(jets, of_a_spray_fill_the_cone_evenly) {
  for (const double half_angle : {5.0, 30.0, 90.0, 150.0}) {
    SCOPED_TRACE(half_angle);
    const auto setup = setup_from(fmt::format(
        "drench: 1\ndomain: {{min: [-9, -9, -9], max: [9, 9, 9]}}\nfluid:\n  spacing: 0.01\n  sources:\n"
        "    - spray: {{center: [1, 2, 3], direction: [2, -1, 2], half_angle: {}, speed: 4, flow: 300, start: 0.01, "
        "end: 0.8}}\n",
        half_angle));
    const Eigen::Vector3d axis = Eigen::Vector3d(2, -1, 2) / 3;
    const auto backend = make_kokkos_backend(setup.model);
    const HostState s = flow_on(setup.model, setup.state, *backend, 0.004, 250);
    const double particles = 300e-3 / 60 * 0.79 / 1e-6, edge = std::cos(half_angle * std::numbers::pi / 180);
    EXPECT_NEAR(static_cast<double>(s.fluid_count()), particles, 0.501);
    EXPECT_EQ(s.supplied - setup.state.supplied, s.fluid_count() * quanta_per_particle);
    double sum = 0, least = 1, speed = 0;
    Eigen::Vector3d mean = Eigen::Vector3d::Zero();
    std::array<int, 4> rings{};  // of equal solid angle
    for (const Vec3& velocity : s.fluid_velocity) {
      const Eigen::Vector3d v = to_eigen(velocity);
      const double cosine = v.dot(axis) / v.norm();
      sum += cosine;
      least = std::min(least, cosine);
      speed = std::max(speed, std::abs(v.norm() - 4));
      mean += v / particles;
      ++rings[static_cast<std::size_t>(std::clamp(4 * (1 - cosine) / (1 - edge), 0.0, 3.0))];
    }
    EXPECT_GE(least, edge - 1e-6);
    EXPECT_LT(least, edge + 0.01 * (1 - edge)) << "up to the edge";
    EXPECT_LT(speed, 1e-5);
    const double scatter = (1 - edge) / std::sqrt(12 * particles);  // of particles in random directions
    EXPECT_NEAR(sum / particles, 0.5 * (1 + edge), 3 * scatter);
    EXPECT_LT((mean - mean.dot(axis) * axis).norm(), 4 / std::sqrt(particles));
    for (const int count : rings) EXPECT_NEAR(count, particles / 4, 3 * std::sqrt(particles));
  }
}

/// Particles of several drops each, which leave at an angle.
TEST(jets, of_rain_agrees_with_the_reference) {
  compare_stage(
      {.stage = Stage::jets,
       .scene = with(wet_scene(), "sources:\n",
                     "sources:\n    - rain: {center: [0, 0.2, 0], size: [0.2, 0.3], rate: 200000, diameter: 0.002, "
                     "velocity: [0.3, -2, 0.1]}\n"),
       .steps_before = 11,
       .changes = "fluid_position"});
}

/// Its axis turns, its flow grows, and both keys lie within the steps.
TEST(jets, with_keys_agree_with_the_reference) {
  for (const std::string between : {"linear", "smooth", "step"})
    compare_stage({.stage = Stage::jets,
                   .scene = with(wet_scene(), "velocity: [0, -1.5, 0.1]}",
                                 "velocity: {keys: [[0, [0, 0, 0]], [0.01, [0, -2, 0]], [0.02, [1.5, -2, 1]], "
                                 "[0.05, [0, -4, 0]]], interpolation: " +
                                     between + "}}"),
                   .steps_before = 11,
                   .changes = "fluid_position"});
}

TEST(jets, of_a_rectangle_agree_with_the_reference) {
  for (const char* mouth : {"size: [0.07, 0.035], velocity: [0, -1.5, 0.1]}",
                            "size: [0.02, 0.1], up: [1, 1, 0], velocity: [[0, [0, -2, 0]], [0.03, [1, -2, 0]]]}"})
    compare_stage({.stage = Stage::jets, .scene = with_mouth(mouth), .steps_before = 11, .changes = "fluid_position"});
}

TEST(jets, that_move_agree_with_the_reference) {
  for (const std::string mouth :
       {"radius: 0.025, velocity: [0, -1.5, 0.1], ", "size: [0.05, 0.04], velocity: [0, -2, 0], ",
        "radius: 0.03, velocity: [[0, [0, 0, 0]], [0.01, [0, -2, 0]], [0.04, [1, -2, 1]]], ",
        "radius: 0.03, velocity: {keys: [[0, [0, -1, 0]], [0.02, [1, -2, 1]], [0.04, [0, -1, 1]]], "
        "interpolation: smooth}, ",
        "radius: 0.03, velocity: {keys: [[0, [0, -1, 0]], [0.02, [1, -2, 1]]], "
        "interpolation: step}, start: 0.003, end: 0.0235, "})
    compare_stage(
        {.stage = Stage::jets, .scene = with_mouth(mouth + motion), .steps_before = 11, .changes = "fluid_position"});
}

TEST(jets, of_meshes_agree_with_the_reference) {
  for (const std::string& keys :
       {std::string("file: FILES, speed: 1.5"), std::string("file: FILES, speed: 2, direction: [1, -1, 0]"),
        std::string("file: FILES, speed: [[0, 0], [0.02, 2]], ") + std::string(motion, std::strlen(motion) - 1),
        std::string("file: FILES, speed: 1, direction: [0, -1, 1], ") + std::string(motion, std::strlen(motion) - 1),
        std::string("sequence: \"FILES\", fps: 60, speed: {keys: [[0, 0.5], [0.03, 2]], interpolation: smooth}"),
        std::string("sequence: \"FILES\", fps: 150, speed: 1.5, direction: [0, -1, 0.5], start: 0.005")})
    compare_stage({.stage = Stage::jets, .scene = with_ball(keys), .steps_before = 11, .changes = "fluid_position"});
}

/// Before the first of its times, which are far apart or close, the mouth stands still.
TEST(jets, of_a_point_cache_agree_with_the_reference) {
  const std::string keys = write_mdd("cached_ball", ball_mesh(0), {0.012F, 0.02F, 0.025F, 0.055F}, point_of_ball);
  const std::string scene =
      with(wet_scene(), "    - jet:", "    - mesh_jet: {" + keys + ", speed: 1.5, start: 0.005}\n    - jet:");
  for (const int steps : {3, 6, 11, 20})
    compare_stage({.stage = Stage::jets, .scene = scene, .steps_before = steps, .changes = "fluid_position"});
}

TEST(jets, that_move_leave_the_same_particles_with_any_step) {
  const std::string scene =
      with(with_ball("sequence: \"FILES\", fps: 60, speed: [[0, 0], [0.03, 2]]"), disc,
           std::string("size: [0.05, 0.04], velocity: [[0, [0, -1, 0]], [0.03, [1, -2, 0]]], ") + motion);
  const drench::Setup setup = setup_from(scene);
  HostState empty = setup.state;
  visit_fields(empty, [](std::string_view name, auto& values) {
    if (name.starts_with("fluid_")) values.clear();
  });
  for (const auto& backend : {make_reference_backend(setup.model), make_kokkos_backend(setup.model)}) {
    SCOPED_TRACE(backend->name());
    const HostState few = flow_on(setup.model, empty, *backend, 0.02, 3),
                    many = flow_on(setup.model, empty, *backend, 0.0025, 24);
    EXPECT_EQ(few.jet_particles, many.jet_particles);
    ASSERT_EQ(few.fluid_count(), many.fluid_count());
    EXPECT_GT(few.jet_particles[0], 20);
    EXPECT_GT(few.jet_particles[1], 10);
    // Their numbers depend on which of two jets is asked first.
    const auto sorted = [](std::vector<Vec3> x) {
      std::sort(x.begin(), x.end());
      return x;
    };
    const std::vector<Vec3> a = sorted(few.fluid_position), b = sorted(many.fluid_position);
    for (std::size_t i = 0; i < a.size(); ++i)
      for (std::size_t c = 0; c < 3; ++c) EXPECT_NEAR(a[i][c], b[i][c], 1e-6);
  }
}

/// The flow is area times speed, whatever moves: here of a mesh whose area grows between files while its speed does.
TEST(jets, that_move_carry_their_flow_to_half_a_particle) {
  const drench::Setup setup = setup_from(
      with(with_ball("sequence: \"FILES\", fps: 60, speed: {keys: [[0.01, 0.5], [0.04, 3]], interpolation: smooth}"),
           disc, std::string("size: [0.05, 0.04], velocity: [0, -1.5, 0], start: 0.004, end: 0.09, ") + motion));
  const Jet &plane = setup.model.jets[0], &ball = setup.model.jets[1];
  EXPECT_DOUBLE_EQ(plane.area, 0.05 * 0.04);
  // An octahedron with corners r from its centre has faces of 4 √3 r².
  EXPECT_NEAR(ball.area, 4 * std::sqrt(3.0) * 0.08 * 0.08, 1e-12);
  const double particle = std::pow(setup.model.spacing, 3);
  double expected = 0;  // by the trapezoidal rule
  int step = 0;
  for (const auto& backend : {make_reference_backend(setup.model), make_kokkos_backend(setup.model)}) {
    backend->upload(setup.state);
    expected = 0;
    for (step = 0; step < 50; ++step) {
      StepReport report;
      backend->run(Stage::jets, {step, 0.002 * step, 0.002}, report);
      constexpr int parts = 400;
      for (int k = 0; k < parts; ++k) {
        const auto flow = [&](int at) {
          const double t = 0.002 * (step + double(at) / parts), file = std::min(60 * t, 3.0);
          return setup.model.scene.fluid.mesh_jets[0].speed.at(t) * area_of_ball(file);
        };
        expected += 0.002 / parts * 0.5 * (flow(k) + flow(k + 1));
      }
      const HostState s = backend->download();
      EXPECT_NEAR(static_cast<double>(s.jet_particles[1]), expected / particle, 0.501) << step;
      EXPECT_NEAR(static_cast<double>(s.jet_particles[0]),
                  0.002 * 1.5 * std::clamp(0.002 * (step + 1) - 0.004, 0.0, 0.086) / particle, 0.5001)
          << step;
      EXPECT_EQ(s.supplied - setup.state.supplied, (s.jet_particles[0] + s.jet_particles[1]) * quanta_per_particle);
    }
  }
  EXPECT_GT(expected / particle, 300);
}

}  // namespace drench::test
