// Cloth as people use it, where it is hard. Every step is watched (tests/support/watch.hpp); README.md lists the cases.

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "hard_scene.hpp"
#include "paths.hpp"
#include "shirt_mesh.hpp"
#include "states.hpp"

namespace drench::test {
namespace {

/// Runs until `end` s, and says which share of the steps had a solve that ended at its cap.
double share_capped(WatchedRun& run, double end, const std::function<void(const HostState&)>& each = {}) {
  int steps = 0, capped = 0;
  while (run.run().time() < end && !::testing::Test::HasFailure())
    run.steps(1, [&](const HostState& s, const StepReport& r) {
      ++steps;
      capped += !(r.cloth_converged && r.density_converged && r.divergence_converged);
      if (each) each(s);
    });
  const double share = steps > 0 ? static_cast<double>(capped) / steps : 1;
  fmt::print("  {} steps to {} s, {:.2g} of them with a solve at its cap\n", steps, end, share);
  return share;
}

double lowest(const std::vector<Vec3>& positions) {
  double y = 1e9;
  for (const Vec3& x : positions) y = std::min(y, x[1]);
  return y;
}

}  // namespace

TEST(garments, bowl_filled_by_a_jet) {
  // 0.6 kg at 1 m/s into a hemisphere of 24 cm, 0.2 kg/m², held at its rim: none leaves it, nothing is faster than the
  // fall.
  WatchedRun run(R"(drench: 1
time: {step: 0.004, end: 2, mode: cfl}
domain: {min: [-0.3, -0.4, -0.3], max: [0.3, 0.3, 0.3]}
fluid:
  spacing: 0.012
  viscosity: 1.0e-4
  sources:
    - jet: {center: [0, 0.05, 0], radius: 0.025, velocity: [0, -1, 0], end: 0.3}
cloth:
  - name: bowl
    mesh: {file: )" + scenes_folder() +
                     R"(/bowl.obj}
    areal_density: 0.2
    stretch: 600
    bend: 1.0e-4
    pin: [{box: {min: [-1, -0.001, -1], max: [1, 0.001, 1]}}]
)",
                 {.fastest = 1.5 * std::sqrt(1 + 2 * 9.81 * 0.25)});
  const double capped = share_capped(run, 0.5);
  run.print("bowl");
  EXPECT_EQ(run.state().drained, 0);
  EXPECT_GT(run.state().fluid_position.size(), 300u);
  for (const Vec3& x : run.state().fluid_position) EXPECT_LT(std::hypot(x[0], x[2]), 0.125) << "beside the bowl";
  EXPECT_EQ(capped, 0);
}

TEST(garments, sheet_pulled_out_of_a_pool) {
  // By one edge, at 2 m/s, from 6 cm under water; dry at first, it soaks, and throws up what it carries.
  WatchedRun run(R"(drench: 1
time: {step: 0.004, end: 2, mode: cfl}
domain: {min: [-0.4, -0.1, -0.4], max: [0.4, 0.9, 0.4]}
fluid:
  spacing: 0.014
  viscosity: 1.0e-4
  sources:
    - block: {min: [-0.182, 0, -0.126], max: [0.182, 0.112, 0.126]}
cloth:
  - name: sheet
    mesh: {grid: {size: [0.24, 0.16], nodes: [25, 17]}}
    place: {position: [0.02, 0.056, 0]}
    areal_density: 0.2
    thickness: 0.001
    stretch: 500
    bend: 1.0e-4
    pin: [{box: {min: [-0.101, 0.05, -0.13], max: [-0.099, 0.07, 0.13]}, velocity: [0, 2, 0], start: 0.1, end: 0.3}]
    porous: {solid_fraction: 0.3, diffusivity: 1.0e-4}
bodies:
  - box: {min: [-0.182, 0, -0.126], max: [0.182, 0.6, 0.126], inside: true}
)",
                 {.fastest = 2 * 2.1});
  const double capped = share_capped(run, 0.4);
  run.print("pulled out");
  EXPECT_GT(run.watch().pin_work(), 0);
  EXPECT_GT(lowest(run.state().node_position), 0.13) << "it is out";
  EXPECT_GT(sum(run.state().node_liquid), 0);
  EXPECT_LE(capped, 0.03);  // three of 131 steps in double
}

TEST(garments, strip_thinner_than_a_particle_in_a_waterfall) {
  // 6 mm wide, held at both ends, in 8 kg/s of water that falls at 2.5 m/s; d = 12 mm. It bends, soaks and lets the
  // water by.
  WatchedRun run(R"(drench: 1
time: {step: 0.004, end: 2, mode: cfl}
domain: {min: [-0.3, -0.4, -0.2], max: [0.3, 0.5, 0.2]}
fluid:
  spacing: 0.012
  viscosity: 1.0e-4
  sources:
    - jet: {center: [0, 0.25, 0], radius: 0.04, velocity: [0, -1.5, 0]}
cloth:
  - name: strip
    mesh: {grid: {size: [0.3, 0.006], nodes: [51, 2]}}
    place: {rotate: {axis: [1, 0, 0], degrees: 20}}
    areal_density: 0.3
    thickness: 0.001
    stretch: 800
    bend: 1.0e-4
    pin: [{box: {min: [-0.151, -1, -1], max: [-0.149, 1, 1]}}, {box: {min: [0.149, -1, -1], max: [0.151, 1, 1]}}]
    porous: {solid_fraction: 0.4}
)",
                 {.fastest = 2 * std::sqrt(1.5 * 1.5 + 2 * 9.81 * 0.65)});
  const double capped = share_capped(run, 0.6);
  run.print("strip");
  EXPECT_GT(sum(run.state().node_liquid), 0);
  EXPECT_GT(run.state().drained, 0) << "the water gets by";
  EXPECT_GT(lowest(run.state().node_position), -0.1) << "it holds";
  EXPECT_LE(capped, 0.01);
}

TEST(garments, wet_shirt_on_a_body_that_jumps) {
  // A soaked shirt on a form that crouches and goes up by 0.3 m within 0.2 s: the shirt leaves its shoulders, falls
  // back on them and drips. What the form puts in is not known from outside; nothing is faster than 2.5 times the form.
  const std::string shirt = write_shapes("shirt", 1, shirt_mesh(15), [](int, const Eigen::Vector3d&x) { return x; }),
                    form = write_shapes("form", 1, form_mesh(40), [](int, const Eigen::Vector3d&x) { return x; });
  const auto file = [](std::string pattern) {
    return pattern.replace(pattern.find("{"), pattern.find("}") + 1 - pattern.find("{"), "0000");
  };
  WatchedRun run(fmt::format(R"(drench: 1
time: {{step: 0.004, end: 2, mode: cfl}}
domain: {{min: [-0.7, -0.5, -0.7], max: [0.7, 1.2, 0.7]}}
fluid:
  spacing: 0.012
  viscosity: 1.0e-4
cloth:
  - name: shirt
    mesh: {{file: {}}}
    place: {{position: [0, 0.02, 0]}}
    areal_density: 0.2
    thickness: 0.002
    stretch: 300
    bend: 5.0e-5
    damping: 2
    friction: 0.4
    friction_wet: 1.0
    self_collision: true
    initial_saturation: [{{box: {{min: [-1, -1, -1], max: [1, 1, 1]}}, value: 1.18}}]
    porous: {{solid_fraction: 0.6, diffusivity: 1.0e-3, capillary_height: 0.3}}
bodies:
  - mesh: {{file: {}, offset: {{keys: [[0.25, [0, 0, 0]], [0.35, [0, -0.05, 0]], [0.55, [0, 0.25, 0]],
        [0.75, [0, 0, 0]]], interpolation: smooth}}}}
)",
                             file(shirt), file(form)),
                 {.energy = HUGE_VAL, .fastest = 2.5 * 1.5 * 0.3 / 0.2});
  std::size_t drops = 0;
  double highest = 0;
  const double capped = share_capped(run, 0.9, [&](const HostState& s) {
    drops = std::max(drops, s.fluid_position.size());
    highest = std::max(highest, lowest(s.node_position));
  });
  run.print("shirt");
  EXPECT_GT(drops, 20u);
  EXPECT_GT(highest, 0.2) << "its hem was at 0.02 m";
  EXPECT_LE(capped, 0.02);
}

}  // namespace drench::test
