// Dynamic bodies and cloth push each other: stage cloth and wet adhesion against the reference, momentum, and bodies
// much lighter than the cloth that they meet. The weight on pins: tests/validation/carried_bodies_test.cpp.

#include <gtest/gtest.h>

#include <cmath>
#include <fstream>

#include "ball_on_sheet.hpp"
#include "paths.hpp"
#include "pipeline/pipeline.hpp"
#include "precision.hpp"
#include "stage_compare.hpp"
#include "two_legs.hpp"

namespace drench::test {
namespace {

const std::string exact = "cloth_solver: {tolerance: 1.0e-4}\n";

double kinetic_energy(const Model& m, const HostState& s) {
  const auto square = [](const Vec3& v) { return v[0] * v[0] + v[1] * v[1] + v[2] * v[2]; };
  double sum = 0.5 * m.bodies[0].mass * square(s.body_velocity[0]);
  for (std::size_t n = 0; n < s.node_velocity.size(); ++n)
    sum += 0.5 * m.mesh.solid_mass[n] * square(s.node_velocity[n]);
  return sum;
}

}  // namespace

TEST(body_reaction, agrees_with_the_reference) {
  for (const double density : {20.0, 500.0}) {
    SCOPED_TRACE(density);
    compare_stage({.stage = Stage::cloth,
                   .scene = scene_of({.density = density, .top = exact}),
                   .steps_before = 10,
                   .changes = "body_velocity"});
  }
  const std::string wet =
      "pin: [{edges: true}]\n    porous: {adhesion: 0.5}\n"
      "    initial_saturation: [{box: {min: [-1, -1, -1], max: [1, 1, 1]}, value: 0.9}]";
  compare_stage({.stage = Stage::wet_adhesion,
                 .scene = scene_of({.density = 300, .cloth = wet, .top = exact}),
                 .steps_before = 10,
                 .changes = "body_velocity"});
}

TEST(body_reaction, a_box_on_cloth_is_turned) {
  const std::string scene =
      with(scene_of({.density = 300, .top = exact}), "sphere: {center: [0.011, 0.056, 0.023], radius: 0.05,",
           "box: {min: [-0.03, 0.006, -0.02], max: [0.09, 0.046, 0.05],");
  compare_stage({.stage = Stage::cloth, .scene = scene, .steps_before = 10, .changes = "body_angular_velocity"});
}

TEST(body_reaction, of_a_mesh_with_two_parts_agrees_with_the_reference) {
  // Its second part is the third solid, after a plane.
  const std::string path = own_file("drench_legs.obj").string();
  std::ofstream(path) << two_legs(0.0015);
  const std::string scene = R"(drench: 1
time: {step: 0.002, end: 1}
domain: {min: [-1, -1, -1], max: [3, 2, 1]}
fluid: {spacing: 0.02, sources: [{block: {min: [2, -0.99, 0], max: [2.04, -0.95, 0.04], velocity: [0, -20, 0]}}]}
cloth:
  - mesh: {grid: {size: [0.1, 0.1], nodes: [7, 7]}}
    thickness: 0.002
    place: {rotate: {axis: [0, 0, 1], degrees: 90}, position: [0.0002, -0.045, 0]}
    pin: [{box: {min: [-1, -1, -0.06], max: [1, 1, -0.04]}}]
    porous: {adhesion: 0.5}
    initial_saturation: [{box: {min: [-1, -1, -1], max: [1, 1, 1]}, value: 0.9}]
bodies:
  - plane: {point: [0, -0.5, 0], normal: [0, 1, 0]}
  - mesh: {file: )" + path + R"(, density: 300, dynamic: true}
cloth_solver: {tolerance: 1.0e-4}
)";
  ASSERT_TRUE(setup_from(scene).model.bodies.back().has_parts());
  for (const Stage stage : {Stage::cloth, Stage::wet_adhesion}) {
    SCOPED_TRACE(static_cast<int>(stage));
    compare_stage({.stage = stage, .scene = scene, .steps_before = 1, .changes = "body_velocity"});
  }
}

TEST(body_reaction, keeps_the_momentum_of_cloth_and_body) {
  for (const char* cloth : {"friction: 0\n    damping: 0", "friction: 0.8\n    damping: 0"}) {
    SCOPED_TRACE(cloth);
    const auto setup = setup_from(scene_of({.cloth = cloth, .top = "gravity: [0, 0, 0]\n" + exact}));
    const auto backend = make_kokkos_backend(setup.model);
    Pipeline pipeline(setup.model, *backend, setup.state);
    const Vec3 before = momentum_with_body(setup.model, setup.state);
    for (int k = 0; k < 40; ++k) pipeline.step(1.0);
    const HostState end = backend->download();
    EXPECT_LT(std::abs(end.body_velocity[0][1]), 0.45) << "the sheet has slowed it down";
    const Vec3 after = momentum_with_body(setup.model, end);
    for (std::size_t a = 0; a < 3; ++a) EXPECT_NEAR(after[a], before[a], 0.01 * std::abs(before[1]));
  }
}

TEST(body_reaction, bodies_lighter_than_the_cloth_stay_calm) {
  for (const double density : {1.0, 30.0}) {
    SCOPED_TRACE(density);
    const auto setup = setup_from(scene_of({.density = density, .cloth = "pin: [{edges: true}]\n    stretch: 5000"}));
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
      fell = std::max(fell, 9.81 * (m.bodies[0].mass * (setup.state.body_position[0][1] - s.body_position[0][1])));
      ASSERT_GT(s.body_position[0][1], -0.2) << "it went through";
    }
    EXPECT_LT(most, 1.5 * (start + fell) + 9.81 * cloth_mass(m) * 0.05) << "J";
  }
}

}  // namespace drench::test
