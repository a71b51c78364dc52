// Walls whose pressure is extrapolated along them: backend against reference, and the law itself.

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "base/eigen_vec.hpp"
#include "precision.hpp"
#include "stage_compare.hpp"
#include "states.hpp"

namespace drench::test {
namespace {

std::string extrapolated(const std::string& scene) {
  return with(scene, "fluid:\n", "fluid:\n  wall_pressure: extrapolated\n");
}

/// A full box, at walls, edges and corners, and a body that swims in it. Before it splashes: a drop with few neighbours
/// has a diagonal so small that κ shows the rounding of δ in floats.
const std::string body_scene = std::string(few_iterations) + R"(
    - block: {min: [0, 0, 0], max: [0.2, 0.24, 0.16]}
bodies:
  - box: {min: [0, 0, 0], max: [0.2, 0.4, 0.16], inside: true}
  - box: {min: [0.04, 0.1, 0.03], max: [0.11, 0.17, 0.12], dynamic: true, density: 600, velocity: [0.1, 0, 0],
          spin: {axis: [1, 1, 3], degrees_per_second: 60}}
)";

/// A drop that wets a plate and a body that floats in it.
const std::string tension_scene =
    with(with(body_scene, "viscosity: 1.0e-3", "viscosity: 1.0e-3\n  surface_tension: 0.5"), "inside: true}",
         "inside: true, adhesion: 0.3}");

/// A cube of 12³ particles that fills its box but for the top, for one evaluation of the pressure.
std::string cube(const std::string& walls) {
  return fmt::format(R"(drench: 1
time: {{step: 0.001, end: 1}}
gravity: [0, 0, 0]
fluid:
  spacing: 0.02
  wall_pressure: {}
  solver: {{max_iterations: 1, min_iterations: 1}}
  sources: [{{block: {{min: [0, 0, 0], max: [0.24, 0.24, 0.24]}}}}]
bodies: [{{box: {{min: [0, 0, 0], max: [0.24, 0.5, 0.24], inside: true}}}}]
)",
                     walls);
}

/// Of the liquid and of the body, and the sums of the magnitudes of the liquid's terms.
struct Momenta {
  Eigen::Vector3d linear = Eigen::Vector3d::Zero(), angular = linear;  // kg m/s, kg m²/s
  double size = 0, moment = 0;
};
Momenta momenta(const Model& model, const HostState& s) {
  Momenta p;
  for (std::size_t i = 0; i < s.fluid_position.size(); ++i) {
    const Eigen::Vector3d x = to_eigen(s.fluid_position[i]),
                          mv = double(s.fluid_mass[i]) * model.quantum * to_eigen(s.fluid_velocity[i]);
    p.linear += mv;
    p.angular += x.cross(mv);
    p.size += mv.norm();
    p.moment += x.norm() * mv.norm();
  }
  const Body& body = model.bodies[0];
  const Eigen::Vector3d v = body.mass * to_eigen(s.body_velocity[0]);
  // At t = 0 the body's axes are the world's.
  p.linear += v;
  p.angular +=
      to_eigen(s.body_position[0]).cross(v) + to_eigen(body.inertia).cwiseProduct(to_eigen(s.body_angular_velocity[0]));
  return p;
}

/// Mean upward acceleration in half the height, over that in the middle: of the particles at one wall, and in the
/// edges.
struct Shares {
  double wall = 0, edge = 0;
};
Shares shares(Backend& backend, const Model& model, HostState s) {
  for (std::size_t i = 0; i < s.fluid_position.size(); ++i)
    s.fluid_kappa_density[i] = 5 - 9.81 * s.fluid_position[i][1];
  const StepInfo info{0, 0, 0.001};
  StepReport report;
  backend.upload(s);
  for (const Stage stage : {Stage::neighbors, Stage::density, Stage::pressure}) backend.run(stage, info, report);
  const HostState end = backend.download();
  double sum[3] = {0, 0, 0};
  int count[3] = {0, 0, 0};
  for (std::size_t i = 0; i < s.fluid_position.size(); ++i) {
    const Vec3& x = s.fluid_position[i];
    if (std::fabs(x[1] - 0.12) > 0.03) continue;
    const auto at_wall = [&](double c) { return std::min(c, 0.24 - c) < 0.6 * model.spacing ? 1 : 0; };
    const int walls = at_wall(x[0]) + at_wall(x[2]);
    sum[walls] += end.fluid_velocity[i][1] / info.dt;
    ++count[walls];
  }
  EXPECT_NEAR(sum[0] / count[0], 9.81, 0.5) << "in the middle";
  return {sum[1] / count[1] * count[0] / sum[0], sum[2] / count[2] * count[0] / sum[0]};
}

}  // namespace

TEST(wall_pressure, agrees_with_the_reference) {
  for (const Stage stage : {Stage::density, Stage::divergence, Stage::pressure}) {
    const std::string changes = stage == Stage::density ? "fluid_density_ratio" : "fluid_velocity";
    compare_stage_with_every_kernel(
        {.stage = stage, .scene = extrapolated(body_scene), .steps_before = 3, .changes = changes});
    compare_stage(
        {.stage = stage, .scene = extrapolated(wet_scene()), .steps_before = 40, .prepare = crowd, .changes = changes});
  }
}

TEST(wall_pressure, moves_bodies_as_in_the_reference) {
  for (const Stage stage : {Stage::divergence, Stage::pressure})
    for (const char* field : {"body_velocity", "body_angular_velocity"})
      compare_stage({.stage = stage, .scene = extrapolated(body_scene), .steps_before = 3, .changes = field});
}

TEST(wall_pressure, counts_for_surface_tension_as_in_the_reference) {
  for (const char* field : {"fluid_velocity", "body_velocity", "body_angular_velocity"})
    compare_stage_with_every_kernel(
        {.stage = Stage::surface_tension, .scene = extrapolated(tension_scene), .steps_before = 3, .changes = field});
  const std::string adhesion_alone = with(tension_scene, "surface_tension: 0.5", "surface_tension: 0");
  compare_stage({.stage = Stage::surface_tension,
                 .scene = extrapolated(adhesion_alone),
                 .steps_before = 3,
                 .changes = "fluid_velocity"});
}

// In a pool without a box nothing but the liquid and the body exchange momentum.
TEST(wall_pressure, gives_to_the_liquid_what_bodies_lose) {
  const drench::Setup setup = setup_from(extrapolated(R"(drench: 1
time: {step: 0.002, end: 1}
gravity: [0, 0, 0]
fluid:
  spacing: 0.02
  surface_tension: 0.5
  sources: [{block: {min: [0, 0, 0], max: [0.2, 0.2, 0.2]}}]
bodies: [{box: {min: [0.06, 0.05, 0.07], max: [0.13, 0.12, 0.15], dynamic: true, density: 300, velocity: [0.4, 0.1, 0],
                spin: {axis: [1, 2, 3], degrees_per_second: 200}}}]
)"));
  for (const auto& backend : {make_reference_backend(setup.model), make_kokkos_backend(setup.model)}) {
    SCOPED_TRACE(backend->name());
    backend->upload(setup.state);
    StepReport report;
    Momenta before = momenta(setup.model, setup.state);
    for (const Stage stage :
         {Stage::neighbors, Stage::density, Stage::divergence, Stage::surface_tension, Stage::pressure}) {
      backend->run(stage, {0, 0, 0.002}, report);
      const HostState s = backend->download();
      const Momenta after = momenta(setup.model, s);
      const double least = double_precision ? 1e-12 : 2e-6;
      EXPECT_LE((after.linear - before.linear).norm(), least * after.size) << static_cast<int>(stage);
      EXPECT_LE((after.angular - before.angular).norm(), least * after.moment) << static_cast<int>(stage);
      before = after;
    }
    EXPECT_NE(backend->download().body_velocity[0], setup.state.body_velocity[0]);
  }
}

TEST(wall_pressure, of_a_scaled_start_agrees_with_the_reference) {
  const std::string scene = body_scene.substr(0, body_scene.find("  - box: {min: [0.04"));
  for (const Stage stage : {Stage::divergence, Stage::pressure})
    compare_stage({.stage = stage,
                   .scene = extrapolated(scene),
                   .steps_before = 3,
                   .last_start = 3,
                   .changes = "fluid_velocity"});
}

TEST(wall_pressure, of_a_linear_field_accelerates_liquid_at_a_wall_as_in_the_middle) {
  for (const bool extrapolates : {false, true}) {
    const drench::Setup setup = setup_from(cube(extrapolates ? "extrapolated" : "mirrored"));
    for (const auto& backend : {make_reference_backend(setup.model), make_kokkos_backend(setup.model)}) {
      SCOPED_TRACE(backend->name());
      const Shares found = shares(*backend, setup.model, setup.state);
      std::printf("%s, %s: of the acceleration in the middle %.4f at a wall, %.4f in an edge\n",
                  backend->name().c_str(), extrapolates ? "extrapolated" : "mirrored", found.wall, found.edge);
      if (extrapolates) {
        EXPECT_NEAR(found.wall, 1, 0.01);
        EXPECT_NEAR(found.edge, 1, 0.02);
      } else {
        EXPECT_LT(found.wall, 0.9) << "what extrapolation is for";
      }
    }
  }
}

}  // namespace drench::test
