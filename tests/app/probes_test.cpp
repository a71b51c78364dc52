// probes.csv: what probes measure of water at rest, of what falls through a disc and of a cloth that hangs.

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "drench/drench.hpp"
#include "run_program.hpp"
#include "same_state.hpp"

namespace drench::test {
namespace {

constexpr double g = 9.81;

const std::string tank = R"(drench: 1
time: {step: 0.002, end: 0.4}
domain: {min: [-0.5, -0.1, -0.5], max: [0.5, 0.5, 0.5]}
output:
  every: 0
  probe_every: 0.1
  probes:
    - {name: middle, point: {position: [0, 0.1, 0]}}
    - {name: wall, point: {position: [0.1, 0.05, 0], radius: 0.05}}
    - {name: air, point: {position: [0, 0.4, 0]}}
    - {name: gauge, line: {from: [0.02, 0, 0.01], to: [0.02, 0.5, 0.01]}}
    - {name: floor, body: tank}
fluid:
  spacing: 0.02
  viscosity: 0.005
  sources:
    - block: {min: [-0.1, 0, -0.1], max: [0.1, 0.2, 0.1]}
bodies:
  - {name: tank, box: {min: [-0.1, 0, -0.1], max: [0.1, 0.5, 0.1], inside: true}}
)";

Table probes_of(const std::string& scene, double until, const TempFolder& folder, HostState* end = nullptr) {
  Simulation run(parse_scene(scene, "probes.yaml"));
  run.record((folder.path() / "out").string());
  run.run_until(until);
  if (end) *end = run.state();
  run.end_record();
  return read_table(folder.path() / "out/probes.csv");
}

double mean(const Table& table, const std::string& column, std::size_t first) {
  double sum = 0;
  for (std::size_t k = first; k < table.rows.size(); ++k) sum += table.number(k, column);
  return sum / static_cast<double>(table.rows.size() - first);
}

}  // namespace

TEST(probes, of_water_at_rest_have_its_pressure_level_and_weight) {
  const TempFolder folder;
  HostState with_probes;
  const Table table = probes_of(tank, 0.4, folder, &with_probes);
  ASSERT_EQ(table.rows.size(), 4U);
  for (std::size_t k = 0; k < 4; ++k) EXPECT_NEAR(table.number(k, "time"), 0.1 * static_cast<double>(k + 1), 1e-9);
  EXPECT_NEAR(mean(table, "middle_pressure", 1), 1000 * g * 0.1, 0.05 * 1000 * g * 0.1);
  EXPECT_NEAR(mean(table, "wall_pressure", 1), 1000 * g * 0.15, 0.05 * 1000 * g * 0.15);
  EXPECT_NEAR(mean(table, "middle_velocity_y", 1), 0, 0.01);
  EXPECT_NEAR(mean(table, "middle_filling", 1), 1, 0.05);
  EXPECT_EQ(mean(table, "air_pressure", 0), 0);
  EXPECT_EQ(mean(table, "air_filling", 0), 0);
  EXPECT_NEAR(mean(table, "gauge_height", 1), 0.2, 0.005);
  EXPECT_NEAR(mean(table, "gauge_depth", 1), 0.2, 0.005);
  EXPECT_NEAR(mean(table, "floor_force_y", 1), -0.04 * 0.2 * 1000 * g, 0.02 * 0.04 * 0.2 * 1000 * g);
  EXPECT_NEAR(mean(table, "floor_force_x", 1), 0, 0.5);
  // They change nothing.
  Scene without = parse_scene(tank, "probes.yaml");
  without.output.probes.clear();
  without.output.probe_every.reset();
  Simulation plain(without);
  plain.run_until(0.4);
  expect_same(with_probes, plain.state());
}

TEST(probes, a_disc_counts_the_mass_that_falls_through_it) {
  const TempFolder folder;
  const Table table = probes_of(R"(drench: 1
time: {step: 0.002, end: 0.2}
domain: {min: [-0.5, -1, -0.5], max: [0.5, 0.5, 0.5]}
output: {every: 0.01, probes: [
  {name: all, disc: {center: [0, -0.05, 0], normal: [0, -2, 0], radius: 0.2}},
  {name: half, disc: {center: [0.2, -0.05, 0], normal: [0, 1, 0], radius: 0.2}}]}
fluid:
  spacing: 0.02
  sources:
    - block: {min: [-0.06, 0, -0.04], max: [0.06, 0.04, 0.04]}
)",
                                0.2, folder);
  ASSERT_EQ(table.rows.size(), 20U);
  const double mass = 1000 * 0.12 * 0.04 * 0.08;
  EXPECT_NEAR(table.number(19, "all_passed"), mass, 1e-9 * mass);
  EXPECT_NEAR(table.number(19, "half_passed"), -mass / 2, 1e-9 * mass);
  double sum = 0;
  for (std::size_t k = 0; k < 20; ++k) sum += 0.01 * table.number(k, "all_flux");
  EXPECT_NEAR(sum, mass, 1e-6 * mass);
}

TEST(probes, discs_count_the_same_mass_whatever_the_interval_of_rows) {
  const auto passed = [](const std::string& every) {
    const TempFolder folder;
    return probes_of(R"(drench: 1
time: {step: 0.001, end: 0.3, mode: cfl}
domain: {min: [-0.2, 0, -0.2], max: [0.2, 0.4, 0.2]}
output:
  every: 0
  probe_every: )" + every +
                         R"(
  probes:
    - {name: mouth, disc: {center: [0, 0.3499, 0], normal: [0, -1, 0], radius: 0.1}}
    - {name: near, disc: {center: [0, 0.32, 0], normal: [0, -1, 0], radius: 0.1}}
    - {name: drain, disc: {center: [0, 0.102, 0], normal: [0, -1, 0], radius: 0.1}}
    - {name: exit, disc: {center: [0, 0.001, 0], normal: [0, -1, 0], radius: 0.1}}
fluid:
  spacing: 0.01
  sources: [{jet: {center: [0, 0.35, 0], radius: 0.03, velocity: [0, -2, 0]}}]
  drains: [{box: {min: [-0.1, 0.05, -0.1], max: [0, 0.1, 0.1]}}]
)",
                     0.3, folder);
  };
  const Table rare = passed("0.1"), often = passed("0.002");
  ASSERT_EQ(rare.rows.size(), 3U);
  ASSERT_EQ(often.rows.size(), 150U);
  const double flow = 1000 * std::numbers::pi * 0.03 * 0.03 * 2;
  for (std::size_t k = 0; k < 3; ++k) {
    for (const char* name : {"mouth_passed", "near_passed", "drain_passed", "exit_passed"})
      EXPECT_NEAR(rare.number(k, name), often.number(50 * k + 49, name), 1e-7) << name << k;
    const double time = 0.1 * static_cast<double>(k + 1);
    EXPECT_NEAR(rare.number(k, "mouth_passed"), flow * time, 0.02 * flow * time);
  }
  // All that the drain and the border of the domain take goes through their discs: half of the jet each.
  const auto since_arrival = [](double fall) { return 0.3 - (std::sqrt(4 + 2 * g * fall) - 2) / g; };
  EXPECT_NEAR(rare.number(2, "near_passed"), flow * since_arrival(0.03), 0.01 * flow * 0.3);
  EXPECT_NEAR(rare.number(2, "drain_passed"), flow * since_arrival(0.248), 0.01 * flow * 0.3);
  EXPECT_NEAR(rare.number(2, "exit_passed"), 0.5 * flow * since_arrival(0.349), 0.02 * flow * 0.3);
}

TEST(probes, of_a_cloth_weigh_it_and_its_water) {
  const TempFolder folder;
  const Table table = probes_of(R"(drench: 1
time: {step: 0.004, end: 2}
output: {every: 0.1, probes: [{name: scale, cloth: towel}]}
cloth:
  - name: towel
    mesh: {grid: {size: [0.2, 0.2], nodes: [11, 11]}}
    place: {rotate: {axis: [1, 0, 0], degrees: 90}}
    areal_density: 0.3
    damping: 4
    pin: [{box: {min: [-1, 0.099, -1], max: [1, 0.101, 1]}}]
    initial_saturation: [{box: {min: [-1, -1, -1], max: [1, 1, 1]}, value: 0.5}]
    porous: {diffusivity: 0, permeability: 1.0e-10, fibre_diameter: 2.0e-5}
    regions: [{box: {min: [-1, -1, -1], max: [0, 1, 1]}, porous: {forchheimer: 1.0e5}}]
)",
                                1.0, folder);
  const std::size_t last = table.rows.size() - 1;
  const double liquid = table.number(last, "scale_liquid");
  EXPECT_NEAR(table.number(last, "scale_saturation"), 0.5, 1e-6);
  EXPECT_GT(liquid, 0.001);
  const double weight = (0.3 * 0.04 + liquid) * g;
  EXPECT_NEAR(table.number(last, "scale_pin_force_y"), weight, 0.02 * weight);
}

TEST(probes, go_on_where_a_run_was_interrupted) {
  const TempFolder folder;
  std::string scene = tank;
  scene.replace(scene.find("every: 0\n"), 9, "every: 0\n  checkpoint_every: 0.03\n");
  scene.replace(scene.find("probe_every: 0.1"), 16, "probe_every: 0.05");
  scene.replace(scene.find("    - {name: wall"), 0,
                "    - {name: tap, disc: {center: [0, 0.35, 0], normal: [0, -1, 0], radius: 0.1}}\n");
  scene.replace(scene.find("    - block"), 0, "    - jet: {center: [0, 0.4, 0], radius: 0.03, velocity: [0, -1, 0]}\n");
  write_text(folder.path() / "scene.yaml", scene);
  const auto whole = run_drench(folder.path(), {"run", "scene.yaml", "-o", "whole", "--until", "0.2"});
  ASSERT_EQ(whole.code, 0) << whole.err;
  const auto first = run_drench(folder.path(), {"run", "scene.yaml", "-o", "part", "--steps", "53"});
  ASSERT_EQ(first.code, 0) << first.err;
  const auto second = run_drench(folder.path(), {"run", "scene.yaml", "--resume", "part", "--until", "0.2"});
  ASSERT_EQ(second.code, 0) << second.err;
  const Table a = read_table(folder.path() / "whole/probes.csv"), b = read_table(folder.path() / "part/probes.csv");
  ASSERT_EQ(a.rows.size(), 4U);
  EXPECT_GT(a.number(3, "tap_passed"), 0.1);
  EXPECT_EQ(read_text(folder.path() / "whole/probes.csv"), read_text(folder.path() / "part/probes.csv"));
}

}  // namespace drench::test
