// Cloth that touches itself inside its solve: rest, friction, momentum, and whole runs (docs/theory/contacts.md, section 8).

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <numbers>

#include "intersections.hpp"
#include "validation.hpp"

namespace drench::test {
namespace {

/// A sheet on a held one, 2 mm thick both, with gravity at `degrees` to the vertical.
std::string sheet_on_sheet(double degrees) {
  const double angle = degrees * std::numbers::pi / 180;
  return fmt::format(R"(drench: 1
time: {{step: 0.004, end: 10}}
cloth_solver: {{self_collision: inside}}
gravity: [{:.9f}, {:.9f}, 0]
cloth:
  - mesh: {{grid: {{size: [0.1, 0.1], nodes: [9, 9]}}}}
    place: {{position: [0.003, 0.00201, 0.002], rotate: {{axis: [0, 1, 0], degrees: 10}}}}
    thickness: 0.002
    friction: 0.5
    damping: 0
    self_collision: true
  - name: held
    mesh: {{grid: {{size: [1.2, 0.14], nodes: [85, 11]}}}}
    place: {{position: [0.5, 0, 0]}}
    thickness: 0.002
    friction: 0.5
    dynamics: false
    self_collision: true
)",
                     9.81 * std::sin(angle), -9.81 * std::cos(angle));
}

/// The mean of a node's position and velocity along an axis over the first cloth.
std::array<double, 2> mean_of(const Model& m, const HostState& s, std::size_t axis) {
  double x = 0, v = 0, count = 0;
  for (std::size_t n = 0; n < s.node_position.size(); ++n) {
    if (m.mesh.node_cloth[n] != 0) continue;
    x += s.node_position[n][axis];
    v += s.node_velocity[n][axis];
    count += 1;
  }
  return {x / count, v / count};
}

/// What a run tells of its solves.
struct Solves {
  int steps = 0, capped = 0, steps_with_zones = 0;
  std::int64_t iterations = 0, contacts = 0;
  double stretch = 0;
  void add(const StepReport& r) {
    ++steps;
    capped += r.cloth_residual > 1;
    steps_with_zones += r.cloth_zone_nodes > 0;
    iterations += r.cloth_iterations;
    contacts = std::max(contacts, r.cloth_contacts);
    stretch = std::max(stretch, r.cloth_stretch);
  }
  void print(const char* what) const {
    std::printf(
        "%s: %d steps, %d at their cap, %.1f iterations a step, most contacts %lld, %d steps with zones, stretch "
        "%.3f\n",
        what, steps, capped, double(iterations) / steps, static_cast<long long>(contacts), steps_with_zones, stretch);
  }
};

}  // namespace

TEST(self_collision, inside_two_sheets_that_collide_keep_their_momentum_to_the_solves_tolerance) {
  SceneRun run(R"(drench: 1
time: {step: 0.004, end: 1}
gravity: [0, 0, 0]
cloth_solver: {tolerance: 1.0e-6, max_iterations: 2000, self_collision: inside}
domain: {min: [-1, -1, -1], max: [1, 1, 1]}
cloth:
  - name: upper
    mesh: {grid: {size: [0.2, 0.2], nodes: [11, 11]}}
    place: {position: [0.013, 0.03, 0.021], rotate: {axis: [0.1, 1, 0.1], degrees: 20}}
    thickness: 0.003
    damping: 0
    self_collision: true
  - name: lower
    mesh: {grid: {size: [0.2, 0.2], nodes: [11, 11]}}
    thickness: 0.003
    areal_density: 0.4
    damping: 0
    self_collision: true
)");
  const Model& m = run.model();
  HostState s = run.initial();
  for (std::size_t n = 0; n < s.node_velocity.size(); ++n)
    s.node_velocity[n] = m.mesh.node_cloth[n] == 0 ? Vec3{0.3, -2, 0.1} : Vec3{-0.1, 0.5, 0};
  // The solve leaves its goal: 1e-6 of the moving forces, and in float ½ ε D L of a node, 4e-5 of m v/Δt (3 kN/m, 20 mm,
  // 80 mg, 2 m/s), in each of 50 steps.
  const auto backend = make_kokkos_backend(m);
  double drift = 0;
  std::int64_t contacts = 0;
  backend->upload(s);
  for (int step = 0; step < 50; ++step) {
    const StepInfo info{step, 0.004 * step, 0.004};
    StepReport done;
    const HostState before = backend->download();
    for (const Stage stage : {Stage::cloth, Stage::self_collision}) backend->run(stage, info, done);
    const HostState after = backend->download();
    Vec3 change{0, 0, 0};
    double size = 0;
    for (std::size_t n = 0; n < after.node_velocity.size(); ++n) {
      const Vec3 &v = before.node_velocity[n], &w = after.node_velocity[n];
      for (std::size_t a = 0; a < 3; ++a) change[a] += m.mesh.solid_mass[n] * (w[a] - v[a]);
      size += m.mesh.solid_mass[n] * std::hypot(w[0], w[1], w[2]);
    }
    drift += std::hypot(change[0], change[1], change[2]) / size;
    contacts += done.cloth_contacts;
    backend->run(Stage::advection, info, done);
  }
  EXPECT_GT(contacts, 500);
  report({"Two sheets collide, contacts in the solve: change of momentum, sum over 50 steps", "conservation", drift,
          double_precision ? 50e-6 : 2e-3, "of Σ m v"});
  EXPECT_EQ(intersections(m, backend->download()), 0);
}

TEST(self_collision, inside_a_sheet_rests_on_a_sheet_at_its_thickness) {
  SceneRun run(sheet_on_sheet(0));
  for (int n = 0; n < 500; ++n) run.step();
  const auto [height, speed] = mean_of(run.model(), run.state(), 1);
  report({"A sheet at rest on a sheet: distance against the thickness", "equal", std::fabs(height / 0.002 - 1), 0.02,
          "1"});
  EXPECT_LE(std::fabs(speed), 1e-4);
}

TEST(self_collision, inside_a_sheet_slides_off_a_sheet_by_coulombs_law) {
  {
    SceneRun run(sheet_on_sheet(20));  // tan 20° = 0.36
    for (int n = 0; n < 250; ++n) run.step();
    const double before = mean_of(run.model(), run.state(), 0)[0];
    for (int n = 0; n < 250; ++n) run.step();
    const double speed = mean_of(run.model(), run.state(), 0)[0] - before;  // over 1 s
    report({"A sheet on a sheet at 20°, friction 0.5: speed", "sticks", std::fabs(speed), 2e-3, "m/s"});
  }
  SceneRun run(sheet_on_sheet(35));
  double start = 0;
  for (int n = 0; n < 100; ++n) {
    run.step();
    if (n == 49) start = mean_of(run.model(), run.state(), 0)[1];
  }
  const double rate = (mean_of(run.model(), run.state(), 0)[1] - start) / 0.2, angle = 35 * std::numbers::pi / 180;
  report({"A sheet that slides on a sheet at 35°, friction 0.5: friction from its acceleration", "μ g cos",
          std::fabs((9.81 * std::sin(angle) - rate) / (0.5 * 9.81 * std::cos(angle)) - 1), 0.02, "1"});
}

TEST(self_collision, inside_a_curtain_drawn_together_is_solved_in_every_step) {
  // Half of scenes/curtain.yaml in each direction, from the start of the pins' way.
  std::string pins;
  for (int k = 0; k <= 5; ++k)
    pins += fmt::format("      - {{nodes: [{}], velocity: [{:.2f}, 0, {}], end: 0.6}}\n", 6 * k, 0.12 * (2.5 - k),
                        k % 2 == 0 ? 0 : 0.02);
  SceneRun run(R"(drench: 1
time: {step: 0.004, end: 4}
cloth_solver: {max_iterations: 400, self_collision: inside}
cloth:
  - mesh: {grid: {size: [0.6, 0.5], nodes: [31, 26]}}
    place: {rotate: {axis: [1, 0, 0], degrees: 90}}
    areal_density: 0.2
    thickness: 0.002
    stretch: 500
    bend: 2.0e-5
    damping: 1.5
    strain_limit: 0.05
    self_collision: true
    pin:
)" + pins);
  Solves all;
  int crossed = 0;
  for (int n = 1; n <= 300; ++n) {
    all.add(run.step());
    if (n % 50 == 0) crossed += intersections(run.model(), run.state());
  }
  all.print("curtain");
  EXPECT_GT(all.contacts, 100);
  EXPECT_EQ(crossed, 0);
  report(
      {"Curtain drawn together: steps whose solve ends at its cap", "none", double(all.capped) / all.steps, 0.01, "1"});
}

TEST(self_collision, inside_a_sheet_that_falls_over_a_sphere_comes_to_rest_in_its_folds) {
  SceneRun run(R"(drench: 1
time: {step: 0.004, end: 4}
cloth_solver: {tolerance: 0.01, self_collision: inside}
cloth:
  - mesh: {grid: {size: [4, 4], nodes: [40, 40]}}
    place: {position: [0, 1.04, 0], rotate: {axis: [0, 1, 0], degrees: 20}}
    areal_density: 0.9
    thickness: 0.004
    stretch: 8000
    bend: 5.0e-4
    damping: 1
    strain_damping: 0.002
    friction: 0.4
    self_collision: true
bodies: [{sphere: {center: [0, 0, 0], radius: 1}}]
)");
  Solves fall, rest;
  double energy = 0;
  for (int n = 0; n < 600; ++n) {
    const StepReport done = run.step();
    (n < 250 ? fall : rest).add(done);
    energy = done.kinetic_energy;
  }
  fall.print("falls");
  rest.print("rests");
  EXPECT_EQ(intersections(run.model(), run.state()), 0);
  EXPECT_GT(rest.contacts, 100);
  report({"Sheet over a sphere, 2.4 s: steps whose solve ends at its cap", "none",
          double(fall.capped + rest.capped) / (fall.steps + rest.steps), 0.01, "1"});
  report({"Sheet over a sphere, from 1 s on: steps with impact zones", "none",
          double(rest.steps_with_zones) / rest.steps, 0.01, "1"});
  report({"Sheet over a sphere, from 1 s on: largest stretch of an edge", "none beyond its weight's", rest.stretch - 1,
          0.08, "1"});
  report({"Sheet over a sphere, after 2.4 s: kinetic energy", "comes to rest", energy / 14.4, 0.03, "J/kg"});
}

}  // namespace drench::test
