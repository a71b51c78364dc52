// Dynamic bodies and cloth push each other: stage cloth and wet adhesion against the reference, momentum, and bodies much lighter
// than the cloth that they meet. The weight on pins: tests/validation/carried_bodies_test.cpp.

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>

#include "pipeline/pipeline.hpp"
#include "precision.hpp"
#include "stage_compare.hpp"

namespace drench::test {
namespace {

/// A ball of radius 50 mm on a sheet of 0.4 m by 0.4 m, and a few particles that leave the domain at once.
std::string ball_on_sheet(double density, const std::string& cloth_keys, const std::string& more = "",
                          const std::string& solver = "cloth_solver: {tolerance: 1.0e-4}\n") {
  return fmt::format(R"(drench: 1
time: {{step: 0.002, end: 100}}
domain: {{min: [-1, -1, -1], max: [3, 2, 1]}}
output: {{every: 0}}
{2}fluid: {{spacing: 0.02, sources: [{{block: {{min: [2, -0.99, 0], max: [2.04, -0.95, 0.04], velocity: [0, -50, 0]}}}}]}}
{3}cloth:
  - mesh: {{grid: {{size: [0.4, 0.4], nodes: [21, 21]}}}}
    thickness: 0.004
    {1}
bodies:
  - sphere: {{center: [0.011, 0.056, 0.023], radius: 0.05, dynamic: true, density: {0}, velocity: [0, -0.5, 0]}}
)",
                     density, cloth_keys, more, solver);
}

double body_mass(const Model& m) { return m.bodies[0].mass; }

double node_mass(const Model& m, const HostState& s, std::size_t n) {
  return m.mesh.solid_mass[n] + m.quantum * static_cast<double>(s.node_liquid[n]);
}

/// Momentum of cloth and body, kg m/s, along an axis.
double momentum(const Model& m, const HostState& s, std::size_t axis) {
  double sum = body_mass(m) * s.body_velocity[0][axis];
  for (std::size_t n = 0; n < s.node_velocity.size(); ++n) sum += node_mass(m, s, n) * s.node_velocity[n][axis];
  return sum;
}

double kinetic_energy(const Model& m, const HostState& s) {
  const auto square = [](const Vec3& v) { return v[0] * v[0] + v[1] * v[1] + v[2] * v[2]; };
  double sum = 0.5 * body_mass(m) * square(s.body_velocity[0]);
  for (std::size_t n = 0; n < s.node_velocity.size(); ++n) sum += 0.5 * node_mass(m, s, n) * square(s.node_velocity[n]);
  return sum;
}

void run_steps(Pipeline& pipeline, int steps) {
  for (int k = 0; k < steps; ++k) pipeline.step(1.0);
}

}  // namespace

TEST(body_reaction, agrees_with_the_reference) {
  for (const double density : {20.0, 500.0}) {
    SCOPED_TRACE(density);
    compare_stage({.stage = Stage::cloth, .scene = ball_on_sheet(density, "pin: [{edges: true}]"), .steps_before = 10,
                   .changes = "body_velocity"});
  }
  const std::string wet = "pin: [{edges: true}]\n    porous: {adhesion: 0.5}\n"
                          "    initial_saturation: [{box: {min: [-1, -1, -1], max: [1, 1, 1]}, value: 0.9}]";
  compare_stage({.stage = Stage::wet_adhesion, .scene = ball_on_sheet(300, wet), .steps_before = 10, .changes = "body_velocity"});
}

TEST(body_reaction, a_box_on_cloth_is_turned) {
  std::string scene = ball_on_sheet(300, "pin: [{edges: true}]");
  scene = with(scene, "sphere: {center: [0.011, 0.056, 0.023], radius: 0.05,",
               "box: {min: [-0.03, 0.006, -0.02], max: [0.09, 0.046, 0.05],");
  compare_stage({.stage = Stage::cloth, .scene = scene, .steps_before = 10, .changes = "body_angular_velocity"});
}

TEST(body_reaction, keeps_the_momentum_of_cloth_and_body) {
  for (const char* cloth : {"friction: 0\n    damping: 0", "friction: 0.8\n    damping: 0"}) {
    SCOPED_TRACE(cloth);
    const auto setup = setup_from(ball_on_sheet(100, cloth, "gravity: [0, 0, 0]\n"));
    const auto backend = make_kokkos_backend(setup.model);
    Pipeline pipeline(setup.model, *backend, setup.state);
    const double before = momentum(setup.model, setup.state, 1);
    run_steps(pipeline, 40);
    const HostState after = backend->download();
    EXPECT_LT(std::abs(after.body_velocity[0][1]), 0.45) << "the sheet has slowed it down";
    EXPECT_NEAR(momentum(setup.model, after, 1), before, 0.01 * std::abs(before));
    for (const std::size_t axis : {0U, 2U}) EXPECT_NEAR(momentum(setup.model, after, axis), 0, 0.01 * std::abs(before));
  }
}

TEST(body_reaction, bodies_lighter_than_the_cloth_stay_calm) {
  for (const double density : {1.0, 30.0}) {
    SCOPED_TRACE(density);
    const auto setup = setup_from(ball_on_sheet(density, "pin: [{edges: true}]\n    stretch: 5000", "", ""));
    const Model& m = setup.model;
    const auto backend = make_kokkos_backend(m);
    Pipeline pipeline(m, *backend, setup.state);
    const double start = kinetic_energy(m, setup.state);
    double most = 0, fell = 0;
    for (int k = 0; k < 120; ++k) {
      pipeline.step(1.0);
      if (k % 10 != 0) continue;
      const HostState s = backend->download();
      most = std::max(most, kinetic_energy(m, s));
      fell = std::max(fell, 9.81 * (body_mass(m) * (setup.state.body_position[0][1] - s.body_position[0][1])));
      ASSERT_GT(s.body_position[0][1], -0.2) << "it went through";
    }
    double cloth = 0;
    for (const double mass : m.mesh.solid_mass) cloth += mass;
    EXPECT_LT(most, 1.5 * (start + fell) + 9.81 * cloth * 0.05) << "J";
  }
}

}  // namespace drench::test
