// Few of something, or suddenly many. Every step is watched (tests/support/watch.hpp); README.md lists the cases.

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "hard_scene.hpp"
#include "restart_scenes.hpp"
#include "states.hpp"

namespace drench::test {
namespace {

double distance(const Vec3& a, const Vec3& b) { return std::hypot(a[0] - b[0], a[1] - b[1], a[2] - b[2]); }

double lowest(const std::vector<Vec3>& positions) {
  double y = 1e9;
  for (const Vec3& x : positions) y = std::min(y, x[1]);
  return y;
}

}  // namespace

TEST(few, no_particle_at_all) {
  // By the scene: liquid could drip out of the cloth, which is dry.
  WatchedRun dry(
      water_over({{"  sources: [{block: {min: [-0.045, 0.0075, -0.045], max: [0.045, 0.0675, 0.045]}}]\n", ""}}));
  dry.steps(60, [](const HostState& s, const StepReport& r) {
    EXPECT_EQ(r.particles, 0);
    EXPECT_EQ(sum(s.node_liquid), 0);
  });
  EXPECT_LT(lowest(dry.state().node_position), -1e-4) << "it sags";
  dry.print("no source, dry cloth");
  // By the state, where the stages of liquid meet bodies and a field; the wet cloth makes the first particles.
  WatchedRun wet(
      water_over({{"cloth:\n",
                   "field: {center: [0, 0, 0], rate: [3, 0, 3]}\nbodies: [{sphere: {center: [0, -0.1, 0], radius: "
                   "0.05, dynamic: true}}]\ncloth:\n"}}),
      {}, [](const Model& m, HostState& s) {
        keep_particles(s, 0);
        soak(m, s, 1.15);
      });
  int first = -1;
  wet.steps(200, [&](const HostState& s, const StepReport& r) {
    if (first < 0 && r.particles > 0) first = static_cast<int>(r.particles);
    for (const auto origin : s.fluid_origin) EXPECT_EQ(origin, static_cast<std::uint8_t>(Origin::cloth));
  });
  EXPECT_GT(first, 0) << "nothing dripped";
  wet.print("no particle, wet cloth");
}

TEST(few, no_cloth) {
  WatchedRun run(water_in_a_box(R"(
    - block: {min: [-0.06, 0, -0.06], max: [0, 0.12, 0.06]}
)"));
  run.steps(150);
  EXPECT_EQ(run.state().fluid_position.size(), run.run().initial().fluid_position.size());
  run.print("no cloth");
}

TEST(few, the_smallest_cloth) {
  for (const char* pin : {"    pin: [{corners: true}]\n", "    pin: [{nodes: [0, 1]}]\n", ""}) {
    WatchedRun run(water_over({{"nodes: [9, 9]", "nodes: [2, 2]"}, {edge_pins, pin}}));
    run.steps(100);
    EXPECT_GT(sum(run.state().node_liquid), 0);
    run.print("two triangles");
  }
}

TEST(few, one_particle) {
  const auto one = [](const Model&, HostState& s) {
    keep_particles(s, 1);
    s.fluid_position[0] = {0.004, 0.01, 0.007};
  };
  WatchedRun taken(water_over({{porous_key, "    porous: {uptake_velocity: 0.05, diffusivity: 1.0e-2}\n"}}), {},
                   [&](const Model& m, HostState& s) {
                     one(m, s);
                     s.fluid_mass[0] = quanta_per_particle / 4;
                   });
  taken.steps(400);
  EXPECT_EQ(taken.watch().absorbed(), 1);
  EXPECT_EQ(sum(taken.state().node_liquid), quanta_per_particle / 4) << "it is in the cloth whole";
  taken.print("one particle, porous");

  WatchedRun held(water_over({{porous_key, ""}}), {}, one);
  held.steps(200, [](const HostState& s, const StepReport& r) {
    EXPECT_EQ(r.particles, 1);
    EXPECT_GT(s.fluid_position[0][1], lowest(s.node_position));
  });
  const Vec3 x = held.state().fluid_position[0];
  EXPECT_LT(std::hypot(x[0], x[2]), 0.12) << "it lies in the hollow that it makes";
  held.print("one particle, tight");
}

TEST(few, a_drop_lies_still_on_light_cloth) {
  // 3.4 g on nodes of 0.05 g. Where only collision stops it, it keeps 0.44 m/s into the sheet on which it lies.
  WatchedRun run(water_over({{"nodes: [9, 9]", "nodes: [17, 17]"},
                             {"    thickness: 0.001\n", "    thickness: 0.001\n    damping: 20\n"},
                             {porous_key, ""}}),
                 {}, [](const Model&, HostState& s) {
                   keep_particles(s, 1);
                   s.fluid_position[0] = {0, 0.0125, 0};
                 });
  double fastest = 0;
  run.steps(300, [&](const HostState& s, const StepReport&) {
    if (s.time < 0.5) return;
    for (const auto* all : {&s.fluid_velocity, &s.node_velocity})
      for (const Vec3& v : *all) fastest = std::max(fastest, std::hypot(v[0], v[1], v[2]));
  });
  run.print("a drop at rest");
  EXPECT_LT(fastest, 0.03);
}

TEST(few, coincident_particles_on_a_sheet) {
  // Compressed 27-fold they burst, at 13 m/s; a spacing a step (7.5 m/s) is the target.
  WatchedRun run(water_over({{porous_key, ""}}), {.energy = HUGE_VAL, .fastest = 2 * 0.015 / 0.002},
                 [](const Model& m, HostState& s) {
                   keep_particles(s, 27);
                   for (Vec3& x : s.fluid_position) x = {0.004, 0.5 * m.spacing, 0.007};
                 });
  run.steps(60);
  const HostState& s = run.state();
  int close = 0;
  for (std::size_t i = 0; i < s.fluid_position.size(); ++i)
    for (std::size_t j = 0; j < i; ++j) close += distance(s.fluid_position[i], s.fluid_position[j]) < 0.2 * 0.015;
  EXPECT_EQ(close, 0) << "pairs within a fifth of a spacing";
  run.print("27 on one point");
}

TEST(few, lists_and_arrays_that_grow) {
  // From no particle to hundreds by two jets and an overfull cloth, on a sheet on which they heap up. A backend that
  // begins in the middle has arrays of the right size from the start and must go on to the same bits.
  const std::string scene = water_over(
      {{"[{block: {min: [-0.045, 0.0075, -0.045], max: [0.045, 0.0675, 0.045]}}]",
        "[{jet: {center: [-0.055, 0.06, 0], radius: 0.04, velocity: [0, -4, 0]}}, {jet: {center: [0.02, 0.09, "
        "0], radius: 0.03, "
        "velocity: [0, -3, 0], start: 0.05}}]"},
       {porous_key, "    initial_saturation: [{box: {min: [-1, -1, -1], max: [1, 1, 1]}, value: 1.18}]\n" +
                        std::string(porous_key)}});
  WatchedRun run(scene);
  std::vector<std::size_t> counts;
  const auto count = [&](const HostState& s, const StepReport&) { counts.push_back(s.fluid_position.size()); };
  run.steps(40, count);
  SceneRun late(scene);
  late.restart(run.state());
  for (int n = 0; n < 17; ++n) late.step();
  run.steps(17, count);
  EXPECT_EQ(different_bits(run.state(), late.state()), "");
  EXPECT_LT(counts.front(), 20u);
  EXPECT_GT(counts.back(), 400u);
  run.print("growing");

  // All at once: the state's particles are thrown on a heap between two steps, forty times as many neighbours as
  // before.
  WatchedRun heap(water_over_sheet);
  heap.steps(3);
  HostState s = heap.state();
  for (std::size_t i = 0; i < s.fluid_position.size(); ++i) {
    const double k = static_cast<double>(i), turn = 2.39996 * k, flat = 2 * (k + 0.5) / 144 - 1, r = 0.006;
    s.fluid_position[i] = {r * std::sqrt(1 - flat * flat) * std::cos(turn), 0.03 + r * flat,
                           r * std::sqrt(1 - flat * flat) * std::sin(turn)};
  }
  heap.run().restart(s);
  Watch burst(heap.model(), s, {.energy = HUGE_VAL});  // it is compressed some hundredfold
  for (int n = 0; n < 30; ++n) {
    heap.run().step();
    for (const std::string& wrong : burst.look(heap.run().state(), heap.run().dt())) ADD_FAILURE() << wrong;
    if (testing::Test::HasFailure()) break;
  }
  std::printf("144 within 12 mm: fastest %.3g m/s\n", burst.largest_speed());
}

TEST(few, all_leave_the_domain) {
  WatchedRun run(water_over({{"fluid:\n", "gravity: [6, -8, 0]\nfluid:\n"},
                             {"domain: {min: [-0.3, -0.3, -0.3], max: [0.3, 0.4, 0.3]}",
                              "domain: {min: [-0.1, -0.05, -0.1], max: [0.1, 0.1, 0.1]}"},
                             {"0.0675, 0.045]}}",
                              "0.0675, 0.045], velocity: [1.5, 1, 0]}}, {jet: {center: [-0.05, 0.05, 0], radius: "
                              "0.02, velocity: [8, 0, 0], end: 0.05}}"},
                             {porous_key, ""}}));
  run.steps(250);
  const HostState& s = run.state();
  EXPECT_GT(s.supplied, 0);
  EXPECT_EQ(s.fluid_position.size(), 0u);
  EXPECT_EQ(s.drained, s.supplied + 144 * quanta_per_particle);
  run.print("all leave");
}

TEST(few, a_rerun_has_the_same_bits) {
  HostState first;
  for (int turn = 0; turn < 2; ++turn) {
    WatchedRun run(porous_scene, {.energy = HUGE_VAL});
    run.steps(20);
    EXPECT_EQ(run.run().time(), run.state().time);
    if (turn == 0)
      first = run.state();
    else
      EXPECT_EQ(different_bits(first, run.state()), "");
  }
  EXPECT_GT(first.fluid_position.size(), 50u);
}

}  // namespace drench::test
