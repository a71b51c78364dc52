// The watch itself: it sees each of the things that the tests of hard cases rely on.

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "hard_scene.hpp"

namespace drench::test {
namespace {

/// What the watch says of a state in which one thing is not as it was.
std::string said_of(const std::function<void(const Model&, HostState&)>& damage, const Rules& rules = {}) {
  SceneRun run(water_over_sheet);
  HostState s = run.initial();
  soak(run.model(), s, 0.5);
  Watch watch(run.model(), s, rules);
  EXPECT_TRUE(watch.look(s, 0.002).empty());
  damage(run.model(), s);
  std::string all;
  for (const std::string& line : watch.look(s, 0.002)) all += line + "\n";
  return all;
}

const std::array<Vec3, 3> unit{{{0, 0, 0}, {1, 0, 0}, {0, 0, 1}}};

std::array<Vec3, 3> moved(std::array<Vec3, 3> t, double y) {
  for (Vec3& x : t) x[1] += y;
  return t;
}

}  // namespace

TEST(watch, counts_how_often_a_point_passes_a_triangle) {
  EXPECT_EQ(crossings({0.2, 1, 0.2}, {0.2, -1, 0.2}, unit, unit), 1);
  EXPECT_EQ(crossings({0.2, -1, 0.2}, {0.2, 1, 0.2}, unit, unit), 1);
  EXPECT_EQ(crossings({0.2, 1, 0.2}, {0.2, 0.1, 0.2}, unit, unit), 0) << "stays above";
  EXPECT_EQ(crossings({0.8, 1, 0.8}, {0.8, -1, 0.8}, unit, unit), 0) << "beside it";
  EXPECT_EQ(crossings({0.2, 0.5, 0.2}, {0.2, 0.5, 0.2}, unit, moved(unit, 1)), 1) << "the triangle comes";
  EXPECT_EQ(crossings({0.2, 0.5, 0.2}, {0.2, 1.5, 0.2}, unit, moved(unit, 1)), 0) << "and carries it";
  // The triangle turns over about its edge along x, once by the point above its middle, once back.
  std::array<Vec3, 3> over = unit;
  over[2] = {0, 0, -1};
  EXPECT_EQ(crossings({0.2, 0.3, 0}, {0.2, 0.3, 0}, unit, over), 0) << "it goes straight, through its own edge";
  over[2] = {0, 2, -1};
  EXPECT_EQ(crossings({0.2, 0.3, 0}, {0.2, 0.3, 0}, unit, over), 1);
}

TEST(watch, sees_what_is_wrong) {
  const auto expect = [](const std::string& said, const char* what) {
    EXPECT_NE(said.find(what), std::string::npos) << "'" << said << "' instead of '" << what << "'";
  };
  EXPECT_EQ(said_of([](const Model&, HostState&) {}), "");
  expect(said_of([](const Model&, HostState& s) { s.node_velocity[7][1] = std::nan(""); }),
         "node_velocity has 1 numbers");
  expect(said_of([](const Model&, HostState& s) { s.fluid_kappa_density[3] = HUGE_VAL; }), "fluid_kappa_density");
  expect(said_of([](const Model&, HostState& s) { ++s.drained; }), "the ledger is off by 1 quanta");
  expect(said_of([](const Model&, HostState& s) {
           s.fluid_position[0][1] = -0.001;
           s.fluid_position[0][0] += 0.001;
         }),
         "passes triangle");
  expect(said_of([](const Model& m, HostState& s) {
           s.fluid_mass[0] = m.min_quanta - 1;
           s.node_liquid[40] += quanta_per_particle - m.min_quanta + 1;
         }),
         "particle 0 has");
  expect(said_of([](const Model& m, HostState& s) {
           const auto bound = static_cast<Quanta>(std::floor(1.18 * m.samples.node_capacity[40] / m.quantum));
           s.fluid_mass[0] -= bound + 1 - s.node_liquid[40];
           s.node_liquid[40] = bound + 1;
         }),
         "node 40 has 1 quanta above");
  expect(said_of([](const Model&, HostState& s) {
           s.fluid_mass[0] += 0;
           s.node_liquid[40] -= s.node_liquid[40] + 1;
           s.drained += s.node_liquid[40];
         }),
         "node 40 has -1 quanta");
  expect(said_of([](const Model&, HostState& s) { s.node_buffered[3] = s.node_liquid[3] + 1; }), "of them buffered");
  expect(said_of([](const Model&, HostState& s) { s.fluid_velocity[5] = {0, 4, 0}; }), "J more than");
  expect(said_of([](const Model&, HostState& s) { s.node_position[40][1] = 0.02; }, {.passage = false}), "J more than");
  expect(said_of(
             [](const Model&, HostState& s) {
               s.fluid_velocity[5] = {3, 0, 0};
             },
             {.energy = HUGE_VAL, .fastest = 2}),
         "3 m/s, more than 2");
}

TEST(watch, excuses_what_is_pinched_between_sheets_that_pass_each_other) {
  const std::string upper = R"(  - name: upper
    mesh: {grid: {size: [0.24, 0.24], nodes: [9, 9]}}
    place: {position: [0, 0.004, 0]}
    areal_density: 0.2
)";
  // The particle begins just below the upper sheet; how far the sheet and it go, and what is said of it.
  const auto passages = [&](double sheet, double particle, std::int64_t excused) {
    SceneRun run(water_over_sheet + upper);
    HostState s = run.initial();
    keep_particles(s, 1);
    s.fluid_position[0] = {0.011, 0.0035, 0.017};
    Watch watch(run.model(), s, {.energy = HUGE_VAL});
    s.fluid_position[0][1] += particle;
    for (std::size_t n = 81; n < 162; ++n) s.node_position[n][1] += sheet;
    std::size_t said = 0;
    for (const std::string& line : watch.look(s, 0.002)) said += line.find("passes triangle") != std::string::npos;
    EXPECT_EQ(watch.pinched(), excused);
    return said;
  };
  EXPECT_EQ(passages(0, -0.001, 0), 0);
  EXPECT_EQ(passages(-0.006, -0.006, 1), 0) << "both sheets cannot have it on their side";
  EXPECT_EQ(passages(-0.003, -0.006, 0), 1) << "the upper sheet is still above the lower one";
  EXPECT_EQ(passages(-0.006, -0.009, 0), 1) << "it does not lie on the upper sheet";
}

TEST(watch, counts_as_many_passages_as_the_run_tells_of_where_it_may) {
  const auto passages = [](bool may, std::int64_t tunnelled, std::int64_t clamped) {
    SceneRun run(water_over_sheet);
    HostState s = run.initial();
    keep_particles(s, 2);
    Watch watch(run.model(), s, {.told_passages = may, .energy = HUGE_VAL});
    for (Vec3& x : s.fluid_position) x = {x[0] + 0.001, -0.001, x[2]};
    StepReport report;
    report.tunnelled = tunnelled;
    report.clamped = clamped;
    const std::size_t said = watch.look(s, 0.002, report).size();
    EXPECT_EQ(said + static_cast<std::size_t>(watch.told()), 2u);
    return said;
  };
  EXPECT_EQ(passages(false, 2, 2), 2u);
  EXPECT_EQ(passages(true, 0, 0), 2u);
  EXPECT_EQ(passages(true, 1, 0), 1u);
  EXPECT_EQ(passages(true, 1, 1), 0u);
}

TEST(watch, knows_where_springs_do_not_count_and_where_no_solve_converged) {
  const auto said = [](const Rules& rules, bool converged, double stretch, double speed) {
    SceneRun run(water_over_sheet);
    HostState s = run.initial();
    Watch watch(run.model(), s, rules);
    s.node_position[40][2] += stretch;
    s.fluid_velocity[5] = {speed, 0, 0};
    StepReport report;
    report.density_converged = converged;
    return watch.look(s, 0.002, report).size();
  };
  EXPECT_EQ(said({}, true, 0.02, 0), 1u);
  EXPECT_EQ(said({.springs = false}, true, 0.02, 0), 0u);
  EXPECT_EQ(said({.springs = false}, true, 0, 4), 1u);
  EXPECT_EQ(said({.capped_energy = 1e3}, true, 0, 4), 1u);
  EXPECT_EQ(said({.capped_energy = 1e3}, false, 0, 4), 0u);
}

TEST(watch, lets_what_is_above_its_bound_fall_and_not_rise_again) {
  SceneRun run(water_over_sheet);
  HostState s = run.initial();
  soak(run.model(), s, 1.5);
  Watch watch(run.model(), s, {});
  const auto pass = [&](Quanta quanta) {
    s.node_liquid[40] += quanta;
    s.drained -= quanta;
    return watch.look(s, 0.002).size();
  };
  EXPECT_EQ(pass(-100), 0u);
  EXPECT_EQ(pass(50), 1u);
}

}  // namespace drench::test
