// What cloth holds, at its bounds. Every step is watched (tests/support/watch.hpp): above all that saturation stays
// within its bound, or only falls where it starts above. README.md lists the cases.

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "hard_scene.hpp"
#include "states.hpp"

namespace drench::test {
namespace {

const std::string no_emission = "processes: {emission: off}\ncloth:\n";

double share_held(const WatchedRun& run) {
  double all = 0;
  for (const double c : run.model().samples.node_capacity) all += c;
  return kilograms(run.model(), sum(run.state().node_liquid)) / all;
}

}  // namespace

TEST(full, a_dry_free_sheet_in_a_pool) {
  // Target: no energy from nothing, as in the other cases; it is missed by half a slack. What is there is the simmering
  // of this water alone (0.03 J, docs/dev/liquid.md).
  WatchedRun run(water_in_a_box(R"(
    - block: {min: [-0.06, 0, -0.06], max: [0.06, 0.12, 0.06]}
cloth:
  - mesh: {grid: {size: [0.09, 0.09], nodes: [7, 7]}}
    place: {position: [0.002, 0.0751, 0.001], rotate: {axis: [1, 0, 0.3], degrees: 10}}
    porous: {uptake_velocity: 0.02}
)"),
                 {.energy = 2});
  run.steps(250);
  run.print("dry sheet in a pool");
  EXPECT_GT(share_held(run), 0.5);
}

TEST(full, saturated_at_the_start) {
  WatchedRun run(water_over_sheet, {}, [](const Model& m, HostState& s) { soak(m, s, 1.18); });
  run.steps(150);
  run.print("saturated");
  EXPECT_GT(share_held(run), 0.95) << "it keeps what it can hold";
}

TEST(full, one_particle_over_100_samples) {
  WatchedRun run(water_over({{"size: [0.24, 0.24], nodes: [9, 9]", "size: [0.04, 0.04], nodes: [17, 17]"},
                             {porous_key, "    porous: {uptake_velocity: 0.02}\n"}}),
                 {}, [](const Model& m, HostState& s) {
                   keep_particles(s, 1);
                   s.fluid_position[0] = {0.003, 0.4 * m.spacing, 0.002};
                   int near = 0;
                   for (const Vec3& x : m.samples.rest_position)
                     near += std::hypot(x[0] - 0.003, x[1] - 0.4 * m.spacing, x[2] - 0.002) < m.support ? 1 : 0;
                   EXPECT_GE(near, 100);
                 });
  run.steps(60);
  run.print("1 over 100");
  EXPECT_GT(sum(run.state().node_liquid), quanta_per_particle / 20);
}

TEST(full, hundred_particles_on_one_sample) {
  // They are compressed a hundredfold and burst; what the sample gets stays within its bound.
  WatchedRun run(water_over({{"size: [0.24, 0.24], nodes: [9, 9]", "size: [0.12, 0.12], nodes: [5, 5]"}}),
                 {.energy = HUGE_VAL}, [](const Model& m, HostState& s) {
                   const Vec3 at = m.samples.rest_position[static_cast<std::size_t>(m.samples.count() / 2)];
                   keep_particles(s, 100);
                   for (std::size_t i = 0; i < 100; ++i) {
                     const double k = double(i), turn = 2.39996 * k, flat = 2 * (k + 0.5) / 100 - 1,
                                  r = m.spacing * (0.3 + 0.01 * k), round = std::sqrt(1 - flat * flat);
                     s.fluid_position[i] = {at[0] + r * round * std::cos(turn), at[1] + r * flat,
                                            at[2] + r * round * std::sin(turn)};
                     if (i % 3 == 0) s.fluid_mass[i] = quanta_per_particle / (i % 2 == 0 ? 11 : 3);
                   }
                 });
  run.steps(80);
  run.print("100 on 1");
  EXPECT_GT(sum(run.state().node_liquid), 0);
}

TEST(full, a_small_particle_that_finds_no_room) {
  // As much room as nothing, a quantum and half a particle of m_min in all: it gives what fits only if that leaves
  // m_min.
  for (const double room : {0.0, 0.5}) {
    WatchedRun run(
        water_over({{"cloth:\n", no_emission}, {porous_key, "    porous: {uptake_velocity: 1, diffusivity: 0}\n"}}), {},
        [&](const Model& m, HostState& s) {
          keep_particles(s, 1);
          s.fluid_position[0] = {0.004, 0.5 * m.spacing, 0.007};
          s.fluid_mass[0] = m.min_quanta;
          for (std::size_t n = 0; n < s.node_liquid.size(); ++n)
            s.node_liquid[n] = static_cast<Quanta>(std::floor(1.18 * m.samples.node_capacity[n] / m.quantum));
          for (const std::size_t n : {40u, 41u, 49u, 50u})
            s.node_liquid[n] -= static_cast<Quanta>(room / 4 * static_cast<double>(m.min_quanta));
        });
    const Quanta at_first = sum(run.state().node_liquid);
    run.steps(150, [&](const HostState& s, const StepReport&) {
      ASSERT_EQ(s.fluid_mass.size(), 1u);
      EXPECT_EQ(s.fluid_mass[0], run.model().min_quanta);
      EXPECT_EQ(sum(s.node_liquid), at_first);
    });
    run.print("no room");
  }
  // With room for all of it, it goes in whole.
  WatchedRun run(water_over({{"cloth:\n", no_emission}, {porous_key, "    porous: {uptake_velocity: 1}\n"}}), {},
                 [](const Model& m, HostState& s) {
                   keep_particles(s, 1);
                   s.fluid_position[0] = {0.004, 0.5 * m.spacing, 0.007};
                   s.fluid_mass[0] = m.min_quanta;
                   soak(m, s, 0.5);
                 });
  run.steps(100);
  EXPECT_EQ(run.watch().absorbed(), 1);
}

TEST(full, overfull_everywhere) {
  for (const char* off :
       {"", "processes: {emission: off}\n", "processes: {diffusion: off}\n", "processes: {direction: off}\n"}) {
    WatchedRun run(water_over({{"cloth:\n", std::string(off) + "cloth:\n"}}), {},
                   [](const Model& m, HostState& s) { soak(m, s, 1.18 * 1.5); });
    const double at_first = share_held(run);
    run.steps(120);
    run.print("overfull");
    const bool drips = std::string(off).find("emission") == std::string::npos;
    EXPECT_EQ(share_held(run) < at_first, drips);
    EXPECT_GT(share_held(run), 1) << "only the excess may leave";
  }
}

TEST(full, blocked_all_round) {
  // Overfull and free to move between two solids: whatever it does, nothing comes out.
  WatchedRun run(water_over({{"[{block: {min: [-0.045, 0.0075, -0.045], max: [0.045, 0.0675, 0.045]}}]",
                              "[{block: {min: [0.2, 0.2, 0.2], max: [0.23, 0.23, 0.23]}}]"},
                             {edge_pins, ""},
                             {"cloth:\n",
                              "bodies:\n  - box: {min: [-0.2, 0.0015, -0.2], max: [0.2, 0.05, 0.2]}\n  - box: {min: "
                              "[-0.2, -0.05, -0.2], max: [0.2, "
                              "-0.0015, 0.2]}\ncloth:\n"}}),
                 {}, [](const Model& m, HostState& s) { soak(m, s, 1.5); });
  const Quanta at_first = sum(run.state().node_liquid);
  run.steps(150, [&](const HostState& s, const StepReport&) {
    ASSERT_EQ(sum(s.node_liquid), at_first);
    for (const Vec3& x : s.node_position) EXPECT_LE(std::fabs(x[1]), 0.000501) << "m";
  });
  run.print("blocked");
}

TEST(full, emission_into_a_crowd) {
  // An overfull sheet within liquid that touches it on both sides: no room for a drop anywhere.
  WatchedRun run(water_in_a_box(R"(
    - block: {min: [-0.06, 0, -0.06], max: [0.06, 0.06, 0.06]}
    - block: {min: [-0.06, 0.075, -0.06], max: [0.06, 0.12, 0.06]}
cloth:
  - mesh: {grid: {size: [0.12, 0.12], nodes: [9, 9]}}
    place: {position: [0, 0.0675, 0]}
    thickness: 0.003
    pin: [{edges: true}]
    porous: {max_saturation: 2}
)"),
                 {}, [](const Model& m, HostState& s) { soak(m, s, 2); });
  run.steps(150);
  run.print("into a crowd");
  EXPECT_EQ(close_pairs(run.state(), 0.1 * 0.015), 0) << "pairs within a tenth of a spacing";
}

TEST(full, almost_solid) {
  // The last is the largest number below 1.
  for (const char* fraction : {"0.99", "0.9999999", "0.99999999999999989"}) {
    WatchedRun run(
        water_over({{porous_key, fmt::format("    porous: {{solid_fraction: {}, diffusivity: 1.0e-3}}\n", fraction)}}),
        {}, [](const Model& m, HostState& s) { soak(m, s, 1.1); });
    const double wet = share_held(run);
    run.steps(80);
    EXPECT_EQ(run.state().fluid_position.size(), 144u) << "none is taken up whole, none can drip";
    run.print(fraction);
    std::printf("  saturation %.4f, %.4f at first\n", share_held(run), wet);
  }
}

TEST(full, the_fastest_exchange) {
  for (const char* porous :
       {"absorption: 100, emission_velocity: 100, virtual_pressure: 100000, emission_ramp: 0",
        "uptake_velocity: 100, emission_velocity: 100, emission_angle: 179, max_saturation: 10",
        "uptake_velocity: 100, diffusivity: 0.02, diffusion: degenerate, capillary_height: 0.001"}) {
    WatchedRun run(water_over({{porous_key, fmt::format("    porous: {{{}}}\n", porous)}}));
    run.steps(100);
    EXPECT_GT(share_held(run), 0.2);
    run.print(porous);
  }
}

}  // namespace drench::test
