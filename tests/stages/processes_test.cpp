// The switches of `processes` and the preset `baseline`: backend against reference, and exact masses whatever is off.

#include <gtest/gtest.h>

#include <algorithm>
#include <numeric>

#include "pipeline/pipeline.hpp"
#include "stage_compare.hpp"

namespace drench::test {
namespace {

std::string with_switches(const std::string& switches) { return with(wet_scene(), "output:", switches + "\noutput:"); }

/// An overfull sheet with room below for what it lets go; some of the liquid stays at it and is half full.
void overfill_over_room(const Model& m, HostState& s) {
  overfill(m, s, 8);
  for (std::size_t i = 0; i < s.fluid_position.size(); ++i) {
    if (i % 4 != 0) s.fluid_position[i][1] += 0.2;
    if (i % 4 == 0) s.fluid_mass[i] /= 2;
  }
}

}  // namespace

TEST(processes, absorption_without_direction_agrees_with_the_reference) {
  compare_stage(
      {.stage = Stage::absorption, .scene = with_switches("processes: {direction: off}"), .changes = "node_liquid"});
}

TEST(processes, absorption_without_saturation_control_agrees_with_the_reference) {
  compare_stage({.stage = Stage::absorption,
                 .scene = with_switches("processes: {saturation_control: off}"),
                 .prepare = overfill_over_room,
                 .changes = "node_liquid"});
}

TEST(processes, absorption_without_emission_removes_what_it_takes_whole) {
  compare_stage({.stage = Stage::absorption,
                 .scene = with(with_switches("processes: {emission: off}"), "thickness: 0.002", "thickness: 0.01"),
                 .prepare =
                     [](const Model&, HostState& s) {
                       for (Quanta& m : s.node_liquid) m = 0;  // room for all of them
                       for (std::size_t i = 0; i < s.fluid_mass.size(); i += 2)
                         s.fluid_mass[i] = quanta_per_particle * 52 / 1000;
                     },
                 .changes = "fluid_id"});
}

TEST(processes, emission_without_direction_agrees_with_the_reference) {
  for (const char* switches : {"processes: {direction: off}", "preset: baseline"}) {
    SCOPED_TRACE(switches);
    compare_stage({.stage = Stage::emission,
                   .scene = with_switches(switches),
                   .steps_before = 2,
                   .prepare = overfill_over_room,
                   .changes = "fluid_id"});
  }
}

TEST(processes, without_direction_liquid_leaves_to_all_sides_and_beside_solids) {
  // A still sheet just above the floor: with a direction the floor blocks it, and liquid above is not in the cone.
  const std::string scene = R"(drench: 1
time: {step: 0.002, end: 1}
domain: {min: [-1, -1, -1], max: [1, 1, 1]}
fluid: {spacing: 0.02, sources: [{block: {min: [-0.02, 0.01, -0.02], max: [0.02, 0.05, 0.02]}}]}
cloth:
  - mesh: {grid: {size: [0.2, 0.2], nodes: [11, 11]}}
    dynamics: false
    thickness: 0.004
    porous: {virtual_pressure: 5}
bodies: [{plane: {point: [0, -0.012, 0], normal: [0, 1, 0]}}]
)";
  for (const bool directed : {true, false}) {
    const auto setup = setup_from(directed ? scene : with(scene, "domain:", "processes: {direction: off}\ndomain:"));
    HostState state = setup.state;
    for (Quanta& m : state.fluid_mass) m /= 2;
    for (std::size_t n = 0; n < state.node_liquid.size(); ++n) {
      state.node_liquid[n] = static_cast<Quanta>(1.15 * setup.model.samples.node_capacity[n] / setup.model.quantum);
      state.node_buffered[n] = state.node_liquid[n] / 10;
    }
    std::vector<Stage> stages{Stage::porous_neighbors, Stage::emission};
    if (directed) stages.insert(stages.begin() + 1, Stage::flow_direction);
    run_on_both(setup.model, state, stages, {0, 0, 0.002}, [&](const Backend& backend, const StepReport&) {
      const HostState after = backend.download();
      bool gained = false;
      for (std::size_t i = 0; i < state.fluid_mass.size(); ++i)
        gained = gained || after.fluid_mass[i] > state.fluid_mass[i];
      EXPECT_EQ(gained, !directed) << "what lies above";
      EXPECT_EQ(after.next_id > state.next_id, !directed) << "new particles";
    });
  }
}

TEST(processes, masses_are_exact_and_bounded_whatever_is_off) {
  for (const std::string switches :
       {"processes: {direction: off}", "processes: {absorption: off}", "processes: {emission: off}",
        "processes: {diffusion: off}", "processes: {absorption: off, emission: off, diffusion: off}",
        "processes: {saturation_control: off}", "preset: baseline",
        "preset: baseline\nprocesses: {emission: off, diffusion: off}"}) {
    SCOPED_TRACE(switches);
    const auto setup = setup_from(with_switches(switches));
    const auto backend = make_kokkos_backend(setup.model);
    Pipeline pipeline(setup.model, *backend, setup.state);
    double saturation = 0;
    for (int s = 0; s < 60; ++s) {
      const StepReport r = pipeline.step(1.0);
      ASSERT_EQ(r.mass_total(), pipeline.initial_total());
      saturation = std::max(saturation, r.saturation_max);
      if (setup.model.has_saturation_control()) {
        ASSERT_LE(r.saturation_max, 1.18);
      }
    }
    const HostState end = backend->download();
    for (const Quanta m : end.node_liquid) ASSERT_GE(m, 0);
    for (const Quanta m : end.fluid_mass) ASSERT_GT(m, 0) << "a particle without mass stays in the arrays";
    if (!setup.model.has_saturation_control()) {
      EXPECT_GT(saturation, 1.18) << "so the switch does something";
    }
    const bool fresh = std::any_of(end.fluid_origin.begin(), end.fluid_origin.end(),
                                   [](std::uint8_t o) { return o == static_cast<std::uint8_t>(Origin::cloth); });
    if (!setup.model.has_emission()) {
      EXPECT_FALSE(fresh);
    }
  }
}

}  // namespace drench::test
