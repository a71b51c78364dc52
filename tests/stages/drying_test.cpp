// Stage drying: backend against reference from identical input, and both against the law.

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>

#include "pipeline/backend.hpp"
#include "quanta_sum.hpp"
#include "stage_compare.hpp"

namespace drench::test {
namespace {

/// A sheet of 0.2 m by 0.2 m at saturation s, in air; further sections stand in `more`.
std::string sheet(double saturation, double critical, double rate, const std::string& more = "") {
  return fmt::format(R"(drench: 1
time: {{step: 0.01, end: 1}}
air: {{evaporation_rate: {2}}}
{3}cloth:
  - mesh: {{grid: {{size: [0.2, 0.2], nodes: [11, 11]}}}}
    dynamics: false
    initial_saturation: [{{box: {{min: [-1, -1, -1], max: [1, 1, 1]}}, value: {0}}}]
    porous: {{critical_saturation: {1}, diffusivity: 0}}
)",
                     saturation, critical, rate, more);
}

constexpr double capacity = 0.6;  // kg/m²: (1 − Φ) τ ρ0

constexpr const char* damp = R"(drench: 1
air: {evaporation_rate: 0.01}
cloth: [{mesh: {grid: {}}, porous: {critical_saturation: 0.5}}]
)";

std::string in_air(const std::string& scene) {
  return with(scene, "output:", "air: {evaporation_rate: 0.02}\noutput:");
}

}  // namespace

TEST(drying, agrees_with_the_reference) {
  const auto overfilled = [](const Model& m, HostState& s) { overfill(m, s, 4); };
  compare_stage({.stage = Stage::drying, .scene = in_air(wet_scene()), .changes = "node_liquid"});
  compare_stage(
      {.stage = Stage::drying, .scene = in_air(wet_scene()), .prepare = overfilled, .changes = "node_liquid"});
  compare_stage({.stage = Stage::drying, .scene = sheet(0.5, 0.3, 0.01), .steps_before = 3, .changes = "node_liquid"});
}

/// With every number of wet parts at once: some nodes are above the critical saturation, some nearly dry.
TEST(drying, cloth_that_cools_agrees_with_the_reference) {
  const std::string cold = "air: {humidity: 0.1, temperature: 40, speed: 3, cooling: true}";
  std::string scene = sheet(0.5, 0.4, 0.01);
  scene = with(scene, "air: {evaporation_rate: 0.01}", cold);
  const auto uneven = [](const Model& m, HostState& s) {
    for (std::size_t n = 0; n < s.node_liquid.size(); ++n)
      s.node_liquid[n] = static_cast<Quanta>(m.samples.node_capacity[n] / m.quantum * std::pow(0.95, double(n)));
  };
  const drench::Setup setup = setup_from(scene);
  EXPECT_GT(setup.model.cooling, 2);
  EXPECT_LT(setup.model.wet_bulb, 25);
  for (const double dt : {0.01, 10.0, 1000.0}) {
    HostState start = setup.state;
    uneven(setup.model, start);
    std::vector<HostState> after;
    run_on_both(setup.model, start, {Stage::drying}, {0, 0, dt},
                [&](const Backend& backend, const StepReport&) { after.push_back(backend.download()); });
    for (std::size_t n = 0; n < start.node_liquid.size(); ++n) {
      EXPECT_NEAR(double(after[0].node_liquid[n]), double(after[1].node_liquid[n]),
                  1 + 1e-9 * double(start.node_liquid[n]))
          << dt << " " << n;
      EXPECT_LE(after[0].node_liquid[n], start.node_liquid[n]);
    }
  }
}

TEST(drying, a_step_of_any_length_is_exact) {
  constexpr double rate = 0.01, critical = 0.25;
  for (const double start : {1.0, 0.2}) {
    const drench::Setup setup = setup_from(sheet(start, critical, rate));
    const double all = 2 * rate / capacity;  // 1/s, by which the saturation falls above the critical one
    for (const double dt : {1e-3, 1.0, 25.0, 60.0}) {
      const double until = std::max(0.0, start - critical) / all;
      const double expected =
          dt < until ? start - all * dt : std::min(start, critical) * std::exp(-all * (dt - until) / critical);
      run_on_both(setup.model, setup.state, {Stage::drying}, {0, 0, dt},
                  [&](const Backend& backend, const StepReport&) {
                    const HostState s = backend.download();
                    for (std::size_t n = 0; n < s.node_liquid.size(); ++n)
                      EXPECT_NEAR(double(s.node_liquid[n]) * setup.model.quantum / setup.model.samples.node_capacity[n],
                                  expected, 1e-6);
                    EXPECT_EQ(sum(s.node_liquid) + s.evaporated, sum(setup.state.node_liquid));
                  });
    }
  }
}

TEST(drying, the_fabric_says_when_it_slows_down) {
  const drench::Setup setup = setup_from(damp);
  EXPECT_EQ(setup.model.cloths[0].critical_saturation, 0.5);
  EXPECT_TRUE(setup.model.has_drying());
  EXPECT_FALSE(setup.model.has_evaporation());
}

TEST(drying, at_the_critical_saturation_0_it_ends_at_once) {
  const drench::Setup setup = setup_from(sheet(0.5, 0, 0.01));
  run_on_both(setup.model, setup.state, {Stage::drying}, {0, 0, 16}, [&](const Backend& backend, const StepReport&) {
    const HostState s = backend.download();
    EXPECT_EQ(sum(s.node_liquid), 0);
    EXPECT_EQ(s.evaporated, sum(setup.state.node_liquid));
  });
}

TEST(drying, rates_below_a_quantum_a_step_are_right_on_average) {
  drench::Setup setup = setup_from(sheet(1, 0, 1));
  const double node = 0.02 * 0.02 * 2 * 0.01 / setup.model.quantum;  // quanta in a step at 1 kg/(m² s)
  setup.model.evaporation_flux = 0.05 / node;
  for (const auto& backend : {make_reference_backend(setup.model), make_kokkos_backend(setup.model)}) {
    SCOPED_TRACE(backend->name());
    backend->upload(setup.state);
    StepReport report;
    constexpr int steps = 2000;
    for (int k = 0; k < steps; ++k) backend->run(Stage::drying, {k, 0, 0.01}, report);
    const double expected = 0.05 * 100 * steps;  // hems have half of a node's area, corners a quarter
    EXPECT_NEAR(double(backend->download().evaporated), expected, 4 * std::sqrt(expected));
  }
}

TEST(drying, covered_sides_stay_wet) {
  const auto lost = [](const std::string& more) {
    const drench::Setup setup = setup_from(sheet(1, 0.3, 0.01, more));
    std::vector<double> middle;  // of a node within the sheet, over what one side loses
    run_on_both(setup.model, setup.state, {Stage::porous_neighbors, Stage::drying}, {0, 0, 0.01},
                [&](const Backend& backend, const StepReport&) {
                  const HostState s = backend.download();
                  const double area = setup.model.samples.node_capacity[60] / capacity,
                               one = area * 0.01 * 0.01 / setup.model.quantum;
                  middle.push_back(double(setup.state.node_liquid[60] - s.node_liquid[60]) / one);
                });
    EXPECT_NEAR(middle[0], middle[1], 1e-3);
    return middle[0];
  };
  const std::string far =
      "fluid: {spacing: 0.01, sources: [{block: {min: [0.5, 0.5, 0.5], max: [0.52, 0.52, 0.52]}}]}\n";
  const std::string above =
      "fluid: {spacing: 0.01, sources: [{block: {min: [-0.1, 0, -0.1], max: [0.1, 0.04, 0.1]}}]}\n";
  const std::string within =
      "fluid: {spacing: 0.01, sources: [{block: {min: [-0.1, -0.04, -0.1], max: [0.1, 0.04, 0.1]}}]}\n";
  const std::string floor = "bodies: [{box: {min: [-0.1, -0.05, -0.1], max: [0.1, -0.002, 0.1]}}]\n";
  EXPECT_NEAR(lost(""), 2, 1e-3);
  EXPECT_NEAR(lost(far), 2, 1e-3);
  EXPECT_NEAR(lost(above), 1, 1e-3);
  EXPECT_NEAR(lost(within), 0, 1e-3);
  EXPECT_NEAR(lost(far + floor), 1, 1e-3);
  EXPECT_NEAR(lost(above + floor), 0, 1e-3);
}

}  // namespace drench::test
