// What moves by keys and files displaces what its keys say: a piston of mesh files in a channel of water, and a jet whose flow
// rises, turns and stops.

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "mesh_sequence.hpp"
#include "validation.hpp"

namespace drench::test {
namespace {

constexpr double d = 0.01;                              // m
constexpr double length = 0.3, width = 0.08, way = 0.1;  // m: of the water, across it, of the piston
constexpr double fps = 20;

/// Of the piston at a time, m: it starts and stops gently, between 1 s and 2 s.
double pushed(double t) {
  const double s = std::clamp(t - 1, 0.0, 1.0);
  return way * s * s * (3 - 2 * s);
}

double mean_height(const HostState& s) {
  double sum = 0;
  for (const Vec3& x : s.fluid_position) sum += x[1];
  return sum / s.fluid_count();
}

}  // namespace

TEST(keyed_motion, a_piston_of_mesh_files_displaces_the_water_that_it_sweeps) {
  const std::string files =
      write_boxes("piston", 50, {0.05, 0.2, 0.06}, [](int k, const Eigen::Vector3d& x) {
        return Eigen::Vector3d(x + Eigen::Vector3d(-0.05 + pushed(k / fps), 0.15, 0));
      });
  SceneRun run(fmt::format(R"(drench: 1
time: {{step: 0.004, end: 10, mode: cfl}}
domain: {{min: [-0.3, -0.1, -0.2], max: [0.5, 1, 0.2]}}
output: {{every: 0}}
fluid:
  spacing: {0}
  viscosity: 2.0e-3
  solver: {{density_error: 1.0e-4, divergence_error: 1.0e-4}}
  sources: [{{block: {{min: [0, 0, -{1}], max: [{2}, 0.1, {1}]}}}}]
bodies:
  - box: {{min: [-0.2, 0, -{1}], max: [{2}, 0.6, {1}], inside: true}}
  - mesh: {{sequence: "{3}", fps: {4}}}
)",
                           d, width / 2, length, files, fps));
  double inside = 0, before = 0, after = 0;
  int samples_before = 0, samples_after = 0;
  while (run.time() < 4) {
    run.step();
    const HostState s = run.state();
    for (const Vec3& x : s.fluid_position) inside = std::max(inside, pushed(run.time()) - x[0]);
    if (run.time() > 0.6 && run.time() < 1) before += mean_height(s), ++samples_before;
    if (run.time() > 3.5) after += mean_height(s), ++samples_after;
  }
  before /= samples_before;
  after /= samples_after;
  // The water's level is twice the height of its centre of mass, and its volume is what the level, the width and the length make.
  const double volume = run.initial().fluid_count() * d * d * d;
  const double swept = volume / (2 * width) * (1 / before - 1 / after);
  std::printf("centre of mass %.5f → %.5f m: the water is %.5f m shorter, the piston came %.5f m; deepest %.2e m\n", before,
              after, swept, way, inside);
  report({"a piston of mesh files: displaced volume, from the centre of mass", "what it swept", std::abs(swept / way - 1), 0.02});
  report({"a piston of mesh files: how deep a particle is in it over d", "none inside", std::max(0.0, inside) / d, 1e-5});
}

TEST(keyed_motion, a_jet_with_keys_carries_the_integral_of_its_flow) {
  double worst = 0;
  for (const char* between : {"linear", "smooth", "step"}) {
    SceneRun run(fmt::format(R"(drench: 1
time: {{step: 0.0037, end: 1, mode: cfl}}
gravity: [0, 0, 0]
domain: {{min: [-1, -1, -1], max: [2, 2, 1]}}
fluid:
  spacing: {}
  sources: [{{jet: {{center: [0, 0, 0], radius: 0.03, start: 0.013,
    velocity: {{keys: [[0, [0, 0, 0]], [0.1, [2, 0, 0]], [0.2, [1, 1, 0]], [0.25, [0, 0, 0]], [0.35, [0, 0, 0]], [0.4, [0, 1, 0]]],
    interpolation: {}}}}}}}]
)",
                             d, between));
    const Keyed<double> speed = run.model().jets[0].speed;
    while (run.time() < 0.5) {
      run.step();
      const double expected = 1000 * std::numbers::pi * 0.03 * 0.03 * speed.integral(0.013, std::max(0.013, run.time()));
      worst = std::max(worst, std::abs(kilograms(run.model(), run.state().supplied) - expected) / run.model().particle_mass);
    }
    EXPECT_GT(run.state().fluid_count(), 100);
  }
  report({"jets with keys: largest difference of the mass from ρ A ∫v over a particle's mass", "ρ A ∫v dt", worst, 0.5001});
}

}  // namespace drench::test
