// Much weight, much speed, large steps, or none of gravity. Every step is watched (tests/support/watch.hpp); README.md
// lists the cases.

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <sstream>

#include "hard_scene.hpp"
#include "paths.hpp"

namespace drench::test {
namespace {

std::string shipped(const std::string& name) {
  std::ifstream in(scenes_folder() + "/" + name);
  std::ostringstream text;
  text << in.rdbuf();
  return text.str();
}

struct Motion {
  double mass = 0;                          // kg
  Vec3 momentum{0, 0, 0}, center{0, 0, 0};  // kg m/s, m
  double size = 0;                          // kg m/s: Σ m |v|
};

Motion motion(const Model& m, const HostState& s) {
  Motion all;
  const auto add = [&](double mass, const Vec3& x, const Vec3& v) {
    all.mass += mass;
    for (std::size_t a = 0; a < 3; ++a) {
      all.momentum[a] += mass * v[a];
      all.center[a] += mass * x[a];
    }
    all.size += mass * std::hypot(v[0], v[1], v[2]);
  };
  for (std::size_t i = 0; i < s.fluid_mass.size(); ++i)
    add(kilograms(m, s.fluid_mass[i]), s.fluid_position[i], s.fluid_velocity[i]);
  for (std::size_t n = 0; n < s.node_liquid.size(); ++n)
    add(m.mesh.solid_mass[n] + kilograms(m, s.node_liquid[n]), s.node_position[n], s.node_velocity[n]);
  for (double& x : all.center) x /= all.mass;
  return all;
}

}  // namespace

TEST(driven, no_gravity) {
  const std::string scene = water_over({{"fluid:\n", "gravity: [0, 0, 0]\nfluid:\n"},
                                        {edge_pins, ""},
                                        {"-0.3, -0.3, -0.3], max: [0.3, 0.4, 0.3]", "-9, -9, -9], max: [9, 9, 9]"}});
  // At rest: overfull cloth and liquid a spacing away. Without a direction nothing leaves and nothing moves.
  WatchedRun still(water_over({{"fluid:\n", "gravity: [0, 0, 0]\nfluid:\n"},
                               {edge_pins, ""},
                               {"min: [-0.045, 0.0075, -0.045], max: [0.045, 0.0675, 0.045]",
                                "min: [-0.045, 0.0375, -0.045], max: [0.045, 0.0975, 0.045]"}}),
                   {.energy = HUGE_VAL}, [](const Model& m, HostState& s) { soak(m, s, 1.15); });
  still.steps(60);
  EXPECT_LE(still.watch().largest_speed(), 1e-4) << "m/s";
  EXPECT_EQ(still.state().fluid_position.size(), 144u);
  still.print("no gravity, at rest");
  // Thrown at the free sheet: it is pushed and soaks, and momentum stays but for the cloth's damping.
  WatchedRun thrown(scene, {}, [](const Model&, HostState& s) {
    for (Vec3& v : s.fluid_velocity) v = {0.3, -2, 0.1};
  });
  const Motion before = motion(thrown.model(), thrown.state());
  thrown.steps(150);
  const Motion after = motion(thrown.model(), thrown.state());
  double drift = 0;
  for (std::size_t a = 0; a < 3; ++a) drift = std::max(drift, std::fabs(after.momentum[a] - before.momentum[a]));
  thrown.print("no gravity, thrown");
  std::printf("  momentum changes by %.2g of Σ m|v|\n", drift / before.size);
  EXPECT_LE(drift / before.size, 2e-2) << "what the damping of the cloth, 1/s, takes in 0.3 s";
  EXPECT_GT(sum(thrown.state().node_liquid), 0);
}

TEST(driven, ten_times_the_diffusivity) {
  // The towel that drips, coarser: 0.05 m²/s are 5 sub-steps a step, and with the paper's factor.
  for (const char* law : {"linear", "degenerate"}) {
    WatchedRun run(with(with(with(with(shipped("wring.yaml"), "spacing: 0.008", "spacing: 0.015"), "nodes: [25, 25]",
                                  "nodes: [13, 13]"),
                             "diffusivity: 5.0e-3", fmt::format("diffusivity: 5.0e-2, diffusion: {}", law)),
                        "measures: true", "measures: false"));
    int sub_steps = 0;
    run.steps(150,
              [&](const HostState&, const StepReport& r) { sub_steps = std::max(sub_steps, r.diffusion_substeps); });
    run.print(law);
    EXPECT_GT(sub_steps, 1);
    EXPECT_LT(sum(run.state().node_liquid), sum(run.run().initial().node_liquid)) << "it drips";
  }
}

std::string coarse_water_on_cloth(const char* step) {
  return with(with(with(with(shipped("water_on_cloth.yaml"), "step: 0.004, end: 1.5, mode: cfl",
                             fmt::format("step: {}, end: 1.5, mode: fixed", step).c_str()),
                        "spacing: 0.008", "spacing: 0.016"),
                   "nodes: [31, 31]", "nodes: [16, 16]"),
              "density_error: 1.0e-4, divergence_error: 1.0e-4", "density_error: 1.0e-3, divergence_error: 1.0e-3");
}

TEST(driven, four_times_the_step) {
  // The jet moves by a spacing a step, against half of one that cfl allows. Some steps end at the cloth's cap.
  WatchedRun run(coarse_water_on_cloth("0.016"));
  run.steps(60);
  run.print("water_on_cloth at 16 ms");
  EXPECT_GT(sum(run.state().node_liquid), 0);
}

TEST(driven, long_steps_that_correct_all_of_a_compression) {
  // What density_correction is for: as many iterations, and less is left of what the steps' length compresses.
  double left[2], iterations[2];
  for (int all = 0; all < 2; ++all) {
    WatchedRun run(with(coarse_water_on_cloth("0.004"), "density_error: 1.0e-3",
                        all ? "density_correction: 1, density_error: 5.0e-4" : "density_error: 1.0e-3"));
    left[all] = iterations[all] = 0;
    run.steps(100, [&](const HostState&, const StepReport& r) {
      left[all] += r.density_error / 100;
      iterations[all] += r.density_iterations / 100.0;
    });
    run.print(all ? "all" : "half");
    fmt::print("  compression left {:.2g}, {:.1f} iterations a step\n", left[all], iterations[all]);
  }
  EXPECT_LT(left[1], 0.3 * left[0]);
  EXPECT_LT(iterations[1], 1.2 * iterations[0]);
}

TEST(driven, pool_filled_beyond_cfl) {
  // Where particles that the sheet stops do not go on along it, they heap up on its nodes: a mean compression of 3.2 %,
  // and single particles of three times water's density. Now 0.2 %.
  WatchedRun run(coarse_water_on_cloth("0.004"));
  double mean = 0, most = 0;
  run.steps(100, [&](const HostState&, const StepReport& r) {
    mean = std::max(mean, r.density_error);
    most = std::max(most, r.density_error_max);
  });
  run.print("water_on_cloth at 4 ms");
  fmt::print("  largest mean compression {:.2g}, of a particle {:.2g}\n", mean, most);
  EXPECT_LT(mean, 0.005);
  EXPECT_LT(most, 0.25);
}

TEST(driven, jet_at_thin_cloth) {
  // 40 mm a step, 2.7 spacings; the cloth is 50 g/m² and 0.1 mm thick, tight or porous. Nothing passes.
  for (const char* porous : {"", porous_key}) {
    WatchedRun run(water_over({{"[{block: {min: [-0.045, 0.0075, -0.045], max: [0.045, 0.0675, 0.045]}}]",
                                "[{jet: {center: [0.01, 0.1, 0], radius: 0.03, velocity: [0, -20, 0], end: 0.06}}]"},
                               {"areal_density: 0.2", "areal_density: 0.05"},
                               {"thickness: 0.001", "thickness: 0.0001\n    stretch: 2000"},
                               {porous_key, porous}}));
    std::int64_t stopped = 0;
    run.steps(15, [&](const HostState&, const StepReport& r) { stopped += r.collisions; });
    EXPECT_GT(stopped, 100);
    run.print("jet of 20 m/s");
  }
}

TEST(driven, hundred_times_the_cloths_mass) {
  // 1.1 kg on 3.6 g of porous cloth (60 g/m²), Δt 8 ms.
  WatchedRun run(water_over({{"step: 0.002", "step: 0.008"},
                             {"max: [0.045, 0.0675, 0.045]", "max: [0.045, 0.1275, 0.045]"},
                             {"areal_density: 0.2", "areal_density: 0.06\n    stretch: 1000"}}));
  run.steps(120);
  run.print("100:1");
}

TEST(driven, soaked_sheet_falls_and_drips) {
  // Free and overfull: it drips while it falls, and all of it together falls at g.
  WatchedRun run(water_over({{"domain: {min: [-0.3, -0.3, -0.3], max: [0.3, 0.4, 0.3]}",
                              "domain: {min: [-9, -9, -9], max: [9, 9, 9]}"},
                             {edge_pins, "    damping: 0\n"},
                             {"thickness: 0.001", "thickness: 0.002"}}),
                 {}, [](const Model& m, HostState& s) {
                   keep_particles(s, 0);
                   soak(m, s, 1.18);
                 });
  const Motion before = motion(run.model(), run.state());
  run.steps(150);
  const Motion after = motion(run.model(), run.state());
  run.print("falls");
  EXPECT_GT(run.state().fluid_position.size(), 0u) << "nothing dripped";
  EXPECT_NEAR(after.momentum[1] / (after.mass * -9.81 * 0.3), 1, 1e-3);
  EXPECT_NEAR(before.momentum[1], 0, 0);
}

TEST(driven, ten_times_its_mass_in_water) {
  // 18 mm of fabric that holds nothing but 10.8 kg/m² of water, at 0.2 kg/m² dry; pinned at its corners, dripping.
  WatchedRun run(water_over({{"thickness: 0.001", "thickness: 0.003"},
                             {"[{edges: true}]", "[{corners: true}]"},
                             {"step: 0.002", "step: 0.004"}}),
                 {}, [](const Model& m, HostState& s) { soak(m, s, 1.18); });
  run.steps(150);
  run.print("10 times its mass");
}

}  // namespace drench::test
