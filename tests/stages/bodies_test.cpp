// Stage bodies, and what moving bodies do in the other stages: backend against reference from identical input.

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <numbers>

#include "paths.hpp"
#include "pipeline/pipeline.hpp"
#include "stage_compare.hpp"

namespace drench::test {
namespace {

/// A scene with a spinning tetrahedron, written beside the system's other temporary files.
std::string spinning_scene() {
  const auto path = own_file("drench_bodies_test.obj");
  std::ofstream(path) << "v 0 0 0\nv 0.1 0 0\nv 0 0.1 0\nv 0 0 0.1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n";
  return "drench: 1\ntime: {step: 0.01, end: 1}\nfluid:\n  spacing: 0.02\n  sources:\n    - block: {min: [0.3, 0, 0], "
         "max: [0.4, "
         "0.1, 0.1]}\nbodies:\n  - mesh: {file: " +
         path.string() + ", velocity: [0.1, 0, 0.2], spin: {axis: [0, 1, 1], degrees_per_second: 180}}\n";
}

/// The wet scene whose sphere and floor move, with a spinning box and a moving container besides.
std::string moving_scene() {
  return with(with(wet_scene(), "radius: 0.05}",
                   "radius: 0.05, velocity: [0.3, 0.5, 0], spin: {axis: [0, 0, 1], "
                   "degrees_per_second: 400}}"),
              "normal: [0, 1, 0]}",
              "normal: [0, 1, 0], velocity: [0, 0.4, 0], spin: {axis: [1, 0, 1], "
              "degrees_per_second: 40}}\n"
              "  - box: {min: [0.02, -0.06, 0.03], max: [0.1, -0.01, 0.1], velocity: [0, 0.3, 0], "
              "spin: {axis: [1, 2, 3], degrees_per_second: 200}}\n"
              "  - box: {min: [-0.3, -0.3, -0.3], max: [0.3, 0.3, 0.3], inside: true, "
              "velocity: [-0.2, 0, 0.1], spin: {axis: [0, 1, 0], degrees_per_second: 30}}");
}

/// A ball as a mesh file, of triangles on latitudes and longitudes.
std::string ball_file(double radius) {
  const auto path = own_file("drench_bodies_ball.obj");
  std::ofstream out(path);
  constexpr int rings = 48, around = 96;
  constexpr double pi = std::numbers::pi;
  out << "v 0 " << radius << " 0\n";
  for (int r = 1; r < rings; ++r)
    for (int k = 0; k < around; ++k)
      out << fmt::format("v {} {} {}\n", radius * std::sin(pi * r / rings) * std::cos(2 * pi * k / around),
                         radius * std::cos(pi * r / rings),
                         radius * std::sin(pi * r / rings) * std::sin(2 * pi * k / around));
  out << "v 0 " << -radius << " 0\n";
  const auto at = [&](int r, int k) {
    return r == 0 ? 1 : r == rings ? 2 + (rings - 1) * around : 2 + (r - 1) * around + k % around;
  };
  for (int r = 0; r < rings; ++r)
    for (int k = 0; k < around; ++k) {
      if (r > 0) out << fmt::format("f {} {} {}\n", at(r, k), at(r, k + 1), at(r + 1, k));
      if (r + 1 < rings) out << fmt::format("f {} {} {}\n", at(r, k + 1), at(r + 1, k + 1), at(r + 1, k));
    }
  return path.string();
}

/// A scene with a sphere of 0.1 m, and with a mesh in its place.
std::array<std::string, 2> with_sphere_and_mesh(const std::string& scene) {
  return {scene + "bodies: [{sphere: {center: [0, 0, 0], radius: 0.1}}]\n",
          scene + "bodies: [{mesh: {file: " + ball_file(0.1) + "}}]\n"};
}

/// The moving scene with a mesh in the sphere's place.
std::string moving_mesh_scene() {
  return with(moving_scene(), "sphere: {center: [0, -0.06, 0], radius: 0.05",
              "mesh: {file: " + ball_file(0.05) + ", position: [0, -0.06, 0]");
}

/// Water in a box with a light box and a heavy sphere in it.
std::string floating_scene() {
  return std::string(few_iterations) + R"(
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
    for (std::size_t i = 0; i < s.fluid_position.size(); i += 7)
      s.fluid_position[i] = {0.04 + 1e-4 * static_cast<double>(i), -0.03, 0.06};  // in the box
    for (std::size_t i = 3; i < s.fluid_position.size(); i += 7)
      s.fluid_position[i] = {0.305, -0.1, 0.1 - 1e-4 * static_cast<double>(i)};
  };
  compare_stage(
      {.stage = Stage::cloth, .scene = moving_scene(), .prepare = onto_the_sphere, .changes = "node_contact_force"});
  // The cloth converges in both. Two iterations of the liquid: from the third on a GPU keeps pairs in 16 bits
  // (docs/dev/comparison.md), which particles as close as these would tell.
  const std::string two =
      with(moving_scene(), "max_iterations: 6, min_iterations: 6", "max_iterations: 2, min_iterations: 2");
  compare_stage({.stage = Stage::pressure,
                 .scene = with(two, "cloth:\n", "cloth_solver: {tolerance: 1.0e-6, max_iterations: 9000}\ncloth:\n"),
                 .prepare = onto_the_sphere,
                 .changes = "fluid_velocity"});
  compare_stage(
      {.stage = Stage::advection, .scene = moving_scene(), .prepare = onto_the_sphere, .changes = "fluid_velocity"});
}

TEST(bodies, meshes_stop_cloth_and_liquid_as_in_the_reference) {
  const auto onto_the_ball = [](const Model&, HostState& s) {
    for (Vec3& x : s.node_position) x[1] -= 0.0095;
    for (std::size_t i = 0; i < s.fluid_position.size(); i += 5) {  // in it
      s.fluid_position[i] = {0.03 * std::cos(i), -0.06 + 0.03 * std::sin(i), 0.01};
      s.fluid_velocity[i] = {0, -1, 0};
    }
  };
  for (const std::string& scene : {moving_mesh_scene(), with(moving_mesh_scene(),
                                                             ", velocity: [0.3, 0.5, 0], spin: "
                                                             "{axis: [0, 0, 1], degrees_per_second: 400}}",
                                                             "}")}) {
    compare_stage({.stage = Stage::cloth, .scene = scene, .prepare = onto_the_ball, .changes = "node_contact_force"});
    compare_stage({.stage = Stage::advection, .scene = scene, .prepare = onto_the_ball, .changes = "fluid_velocity"});
  }
}

TEST(bodies, cloth_drapes_over_a_mesh_ball_as_over_a_sphere) {
  const auto scenes = with_sphere_and_mesh(R"(drench: 1
time: {step: 0.004, end: 1}
cloth:
  - mesh: {grid: {size: [0.3, 0.3], nodes: [21, 21]}}
    place: {position: [0, 0.105, 0]}
    thickness: 0.002
)");
  HostState end[2];
  for (std::size_t k = 0; k < 2; ++k) {
    const auto setup = setup_from(scenes[k]);
    const auto backend = make_kokkos_backend(setup.model);
    Pipeline pipeline(setup.model, *backend, setup.state);
    for (int step = 0; step < 40; ++step) pipeline.step(1.0);
    end[k] = backend->download();
  }
  double worst = 0, lowest = 1, touching[2] = {0, 0};
  for (std::size_t n = 0; n < end[0].node_position.size(); ++n) {
    double apart = 0;
    for (int a = 0; a < 3; ++a) apart += std::pow(end[0].node_position[n][a] - end[1].node_position[n][a], 2);
    worst = std::max(worst, std::sqrt(apart));
    const Vec3& x = end[1].node_position[n];
    lowest = std::min(lowest, std::hypot(x[0], x[1], x[2]));
    for (int k = 0; k < 2; ++k) touching[k] += end[k].node_contact_force[n] != Vec3{0, 0, 0};
  }
  EXPECT_GT(touching[0], 20);
  EXPECT_NEAR(touching[1], touching[0], 0.2 * touching[0]);
  // The mesh's triangles lie up to 0.11 mm below the sphere, and the lattice of s = 7.5 mm takes a point for
  // s²/8 · 2/R = 0.14 mm higher than it is.
  EXPECT_NEAR(lowest, 0.102, 0.00025);
  EXPECT_LT(worst, 0.001);
}

TEST(bodies, a_mesh_ball_puts_liquid_back_as_a_sphere_does) {
  const auto scenes = with_sphere_and_mesh(R"(drench: 1
time: {step: 0.002, end: 1}
fluid: {spacing: 0.02, sources: [{block: {min: [0.2, 0.1, -0.1], max: [0.4, 0.2, 0.1]}}]}
)");
  HostState end[2];
  for (std::size_t k = 0; k < 2; ++k) {
    const auto setup = setup_from(scenes[k]);
    const double fewest = std::round(4 * std::numbers::pi * 0.09 * 0.09 / 0.0004);
    EXPECT_GE(setup.state.boundary_count(), fewest) << "a layer half a spacing inside";
    EXPECT_LE(setup.state.boundary_count(), k ? fewest / (0.75 * 0.75) : fewest);
    for (const Vec3& x : setup.state.boundary_position) EXPECT_NEAR(std::hypot(x[0], x[1], x[2]), 0.09, 0.0005);
    HostState s = setup.state;
    for (std::size_t i = 0; i < s.fluid_position.size(); ++i) {
      const double r = 0.085 + 0.0125 * static_cast<double>(i) / static_cast<double>(s.fluid_position.size()),
                   a = 0.7 * i;
      s.fluid_position[i] = {r * std::cos(a), r * std::sin(a) * std::cos(2.0 * i), r * std::sin(a) * std::sin(2.0 * i)};
      s.fluid_velocity[i] = {-3 * s.fluid_position[i][0], 1, -3 * s.fluid_position[i][2]};
    }
    const auto backend = make_kokkos_backend(setup.model);
    backend->upload(s);
    StepReport report;
    for (const Stage stage : {Stage::neighbors, Stage::density, Stage::advection})
      backend->run(stage, {0, 0, 0.002}, report);
    EXPECT_EQ(report.clamped, s.fluid_count());
    end[k] = backend->download();
  }
  for (std::size_t i = 0; i < end[0].fluid_position.size(); ++i)
    for (int a = 0; a < 3; ++a) {
      // The slope of a lattice of s = 10 mm is off by up to √2 s/(2R) = 0.071 rad; the way back is up to 15 mm, the
      // speed about 1.05 m/s.
      EXPECT_NEAR(end[0].fluid_position[i][a], end[1].fluid_position[i][a], 0.0011);
      EXPECT_NEAR(end[0].fluid_velocity[i][a], end[1].fluid_velocity[i][a], 0.075);
    }
}

TEST(bodies, dynamic_bodies_answer_as_in_the_reference) {
  // Before it splashes: a drop with few neighbours has a diagonal so small that κ shows the rounding of δ in floats
  // (1.1e-4 after 12 steps; in double the same comparison holds to 1e-10).
  for (const Stage stage : {Stage::density, Stage::divergence, Stage::forces, Stage::pressure}) {
    SCOPED_TRACE(name_of(stage));
    compare_stage({.stage = stage,
                   .scene = floating_scene(),
                   .steps_before = 5,
                   .changes = stage == Stage::density ? "fluid_density_ratio" : "body_angular_velocity"});
  }
}

TEST(bodies, what_dynamic_bodies_get_the_liquid_loses) {
  // Momentum and angular momentum of liquid and bodies together, in a pool without walls.
  const auto setup =
      setup_from(with(floating_scene(), "  - box: {min: [-0.15, 0, -0.15], max: [0.15, 1, 0.15], inside: true}\n", ""));
  const double dt = 0.002;
  const auto momenta = [&](const HostState& s) {
    std::array<double, 6> sum{};
    double scale = 0;
    const auto add = [&](double mass, const Vec3& x, const Vec3& v) {
      for (std::size_t a = 0; a < 3; ++a) {
        const std::size_t b = (a + 1) % 3, c = (a + 2) % 3;
        sum[a] += mass * v[a];
        sum[3 + a] += mass * (x[b] * v[c] - x[c] * v[b]);
        scale += mass * std::abs(v[a]);
      }
    };
    for (std::size_t i = 0; i < s.fluid_position.size(); ++i)
      add(static_cast<double>(s.fluid_mass[i]) * setup.model.quantum, s.fluid_position[i], s.fluid_velocity[i]);
    for (std::size_t k = 0; k < s.body_position.size(); ++k) {
      const Body& body = setup.model.bodies[k];
      add(body.mass, s.body_position[k], s.body_velocity[k]);
      for (std::size_t a = 0; a < 3; ++a)  // as long as it has hardly turned
        sum[3 + a] += body.inertia[a] * s.body_angular_velocity[k][a];
    }
    return std::pair(sum, scale);
  };
  for (const auto& backend : {make_reference_backend(setup.model), make_kokkos_backend(setup.model)}) {
    for (const Stage stage : {Stage::divergence, Stage::forces, Stage::pressure}) {
      HostState s = setup.state;
      for (std::size_t i = 0; i < s.fluid_position.size(); ++i)  // squeezed and sheared
        for (std::size_t a = 0; a < 3; ++a) {
          s.fluid_velocity[i][a] -= 3 * s.fluid_position[i][(a + i % 2) % 3];
          s.fluid_position[i][a] *= 0.97;
        }
      backend->upload(s);
      StepReport report;
      for (const Stage before : {Stage::neighbors, Stage::density, stage}) backend->run(before, {0, 0, dt}, report);
      const HostState end = backend->download();
      const auto [start, scale] = momenta(s);
      auto expected = start;  // clang 14's lambdas cannot capture a part of a structured binding
      const auto found = momenta(end).first;
      if (stage == Stage::forces) {
        const auto weight = [&](double mass, const Vec3& x) {
          expected[1] -= dt * 9.81 * mass;
          expected[3] += dt * 9.81 * mass * x[2];
          expected[5] -= dt * 9.81 * mass * x[0];
        };
        for (std::size_t i = 0; i < s.fluid_position.size(); ++i)
          weight(static_cast<double>(s.fluid_mass[i]) * setup.model.quantum, s.fluid_position[i]);
        for (std::size_t k = 0; k < 2; ++k) weight(setup.model.bodies[k].mass, s.body_position[k]);
      }
      for (std::size_t a = 0; a < 6; ++a) EXPECT_NEAR(found[a], expected[a], 1e-6 * scale) << name_of(stage) << a;
      EXPECT_NE(end.body_velocity[1], s.body_velocity[1]);
      EXPECT_NE(end.body_angular_velocity[0], s.body_angular_velocity[0]);
    }
  }
}

TEST(bodies, a_moving_wall_pushes_and_a_receding_one_does_not) {
  for (const double speed : {1.0, -1.0}) {
    const auto setup = setup_from(with(R"(drench: 1
time: {step: 0.002, end: 1}
fluid: {spacing: 0.02, sources: [{block: {min: [-0.1, 0.001, -0.1], max: [0.1, 0.021, 0.1]}}]}
bodies: [{plane: {point: [0, 0, 0], normal: [0, 1, 0], velocity: [0.5, SPEED, 0]}}]
)",
                                       "SPEED", std::to_string(speed)));
    HostState s = setup.state;
    for (Vec3& x : s.fluid_position) x[1] = 0.001;
    for (Vec3& v : s.fluid_velocity) v = {0, -0.7, 0};
    run_on_both(setup.model, s, until_advection, {0, 0, 0.002}, [&](const Backend& backend, const StepReport&) {
      const HostState end = backend.download();
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
    });
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
