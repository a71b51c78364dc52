// States that a program gives to a run: the mass budget, bits after restoring, what is refused.

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <limits>

#include "drench/drench.hpp"
#include "same_state.hpp"
#include "state/mass_budget.hpp"

namespace drench::test {
namespace {

Scene scene() {
  return parse_scene(R"(drench: 1
time: {step: 0.002, end: 1.0}
domain: {min: [-0.5, -0.5, -0.5], max: [0.5, 0.5, 0.5]}
fluid:
  spacing: 0.02
  sources:
    - block: {min: [-0.08, 0.03, -0.08], max: [0.08, 0.11, 0.08]}
cloth:
  - mesh: {grid: {size: [0.4, 0.4], nodes: [11, 11]}}
    pin: [{edges: true}]
    porous: {}
)",
                     "given_state.yaml");
}

TEST(given_state, a_run_restored_to_a_state_repeats_its_bits) {
  Simulation run(scene());
  for (int k = 0; k < 10; ++k) run.step();
  run.set_wind({0.5, 0, 0});
  const HostState state = run.state();
  const std::vector<double> changes = run.changes();
  for (int k = 0; k < 10; ++k) run.step();
  const HostState later = run.state();
  Simulation other(scene());
  for (Simulation* again : {&run, &other}) {
    again->restore(state, changes);
    EXPECT_EQ(again->steps(), 10);
    for (int k = 0; k < 10; ++k) again->step();
    expect_same(later, again->state());
  }
}

TEST(given_state, reset_returns_to_the_start_each_time) {
  Simulation run(scene());
  const HostState start = run.state();
  for (int k = 0; k < 5; ++k) run.step();
  const HostState later = run.state();
  for (int round = 0; round < 2; ++round) {
    run.set_wind({3, 0, 0});
    run.step();
    run.reset();
    expect_same(start, run.state());
    EXPECT_TRUE(run.changes().empty());
    for (int k = 0; k < 5; ++k) run.step();
    expect_same(later, run.state());
  }
}

TEST(given_state, added_and_removed_liquid_stands_in_the_mass_budget) {
  Simulation run(scene());
  const Quanta at_start = liquid_budget(run.state());
  run.step();
  HostState state = run.state();
  const auto count = state.fluid_position.size();
  visit_fields(state, [](std::string_view name, auto& values) {  // the first particle goes, another one comes
    if (name.starts_with("fluid_") && !values.empty()) values.erase(values.begin());
  });
  state.fluid_mass.back() -= 1000;
  state.node_liquid[60] += 5000;
  run.set_state(state);
  state = run.state();
  EXPECT_EQ(state.fluid_position.size(), count - 1);
  EXPECT_EQ(state.drained, quanta_per_particle + 1000 - 5000);
  EXPECT_EQ(liquid_budget(state), at_start);
  state.fluid_id.push_back(state.next_id);
  state.next_id += 1;
  state.fluid_position.push_back({0, 0.3, 0});
  state.fluid_velocity.push_back({0, -40, 0});
  state.fluid_mass.push_back(quanta_per_particle);
  state.fluid_origin.push_back(static_cast<std::uint8_t>(Origin::program));
  visit_fields(state, [&](std::string_view name, auto& values) {
    if (name.starts_with("fluid_") && !values.empty()) values.resize(count);
  });
  run.set_state(state);
  for (int k = 0; k < 20; ++k) {
    const StepReport report = run.step();  // also: a fast particle that a program added is no runaway
    EXPECT_EQ(report.mass_total(), at_start);
  }
  EXPECT_EQ(run.state().supplied, quanta_per_particle);
}

TEST(given_state, refuses_values_by_field_and_row_and_keeps_the_run) {
  Simulation run(scene());
  run.step();
  const HostState state = run.state();
  const auto refused = [&](const std::string& with, const std::function<void(HostState&)>& change) {
    HostState wrong = state;
    change(wrong);
    try {
      run.set_state(wrong);
      ADD_FAILURE() << "accepted: " << with;
    } catch (const std::invalid_argument& e) {
      EXPECT_NE(std::string(e.what()).find(with), std::string::npos) << e.what();
    }
    expect_same(state, run.state());
  };
  refused("node_position[3]", [](HostState& s) { s.node_position[3][1] = std::nan(""); });
  refused("node_velocity: 120 rows; this run needs 121", [](HostState& s) { s.node_velocity.pop_back(); });
  refused("fluid_mass[2]", [](HostState& s) { s.fluid_mass[2] = 0; });
  refused("fluid_mass[2]", [](HostState& s) { s.fluid_mass[2] = 3 * quanta_per_particle; });
  refused("fluid_id[1]", [](HostState& s) { s.fluid_id[1] = s.fluid_id[0]; });
  refused("next_id", [](HostState& s) { s.fluid_id.back() = s.next_id; });
  refused("fluid_position[0]: outside the domain", [](HostState& s) { s.fluid_position[0][0] = 0.6; });
  refused("node_liquid[7]", [](HostState& s) { s.node_liquid[7] = -1; });
  refused("node_liquid[60]: a saturation of 10; allowed: up to 1",
          [&](HostState& s) { s.node_liquid[60] = std::llround(10 * run.node_capacity()[60] / run.quantum()); });
  refused("fluid_velocity[4]: 1e+30 m/s; allowed: [-1000, 1000]", [](HostState& s) { s.fluid_velocity[4][2] = 1e30; });
  refused("node_velocity[9]: -2000 m/s; allowed: [-1000, 1000]", [](HostState& s) { s.node_velocity[9][0] = -2000; });
  refused("node_position[3]: 1e+09 m; allowed: [-10000, 10000]", [](HostState& s) { s.node_position[3][1] = 1e9; });
  refused("node_liquid[1]",
          [](HostState& s) { s.node_liquid[0] = s.node_liquid[1] = std::numeric_limits<Quanta>::max() / 5; });
  refused("node_buffered[7]", [](HostState& s) { s.node_buffered[7] = s.node_liquid[7] + 1; });
}

}  // namespace
}  // namespace drench::test
