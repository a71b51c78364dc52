// Stage permeation: backend against reference from identical input, and the flux of pressures that are known.

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>

#include "pipeline/backend.hpp"
#include "precision.hpp"
#include "quanta_sum.hpp"
#include "stage_compare.hpp"

namespace drench::test {
namespace {

const double tolerance = double_precision ? 1e-10 : 1e-4;

std::string permeable(const std::string& keys = "permeability: 1.0e-8") {
  return with(wet_scene(), "porous: {", "porous: {" + keys + ", ");
}

/// Water on both sides of a sheet in the plane y = 0, 40 mm above it and 20 mm below, with the pressure of a head of 50
/// mm at the sheet's upper face and of 10 mm at its lower one.
struct Between {
  static constexpr double gravity = 9.81, thickness = 0.002, viscosity = 1e-3, permeability = 1e-8;
  drench::Setup setup;

  explicit Between(const std::string& keys, double low = 10e-3, double high = 50e-3)
      : setup(setup_from(fmt::format(R"(drench: 1
time: {{step: 0.001, end: 1}}
fluid:
  spacing: 0.005
  viscosity: {0}
  sources:
    - block: {{min: [-0.02, 0, -0.02], max: [0.02, 0.04, 0.02]}}
    - block: {{min: [-0.02, -0.02, -0.02], max: [0.02, 0, 0.02]}}
cloth:
  - mesh: {{grid: {{size: [0.04, 0.04], nodes: [9, 9]}}}}
    dynamics: false
    thickness: {1}
    initial_saturation: [{{box: {{min: [-1, -1, -1], max: [1, 1, 1]}}, value: 1}}]
    porous: {{permeability: {2}, diffusivity: 0{3}}}
)",
                                     viscosity, thickness, permeability, keys))) {
    HostState& s = setup.state;
    for (std::size_t i = 0; i < s.fluid_position.size(); ++i) {
      const double y = s.fluid_position[i][1], kappa = gravity * ((y > 0 ? high : low) - y);
      s.fluid_kappa_density[i] = 0.75 * kappa;
      s.fluid_kappa_divergence[i] = 0.25 * kappa;
    }
  }
  /// u that Darcy has for a head of so many metres, against the sheet's normal: down.
  static double flux(double head) { return permeability * gravity * head / (viscosity * thickness); }
};

void run_until(Backend& backend, const HostState& state, Stage last) {
  StepReport report;
  backend.upload(state);
  for (const Stage s :
       {Stage::porous_neighbors, Stage::flow_direction, Stage::permeation, Stage::absorption, Stage::emission}) {
    backend.run(s, {0, 0, 0.001}, report);
    if (s == last) return;
  }
}

}  // namespace

TEST(permeation, agrees_with_the_reference) {
  compare_stage({.stage = Stage::permeation, .scene = permeable(), .changes = "sample_flux sample_flow_direction"});
  compare_stage({.stage = Stage::permeation,
                 .scene = permeable("permeability: 1.0e-8, breakthrough_pressure: 300"),
                 .changes = "sample_flux"});
  for (const char* drag : {"forchheimer: 2.0e5", "fibre_diameter: 2.0e-5"})
    for (const char* entry : {"", ", breakthrough_pressure: 300"})
      compare_stage({.stage = Stage::permeation,
                     .scene = permeable(fmt::format("permeability: 1.0e-8, {}{}", drag, entry)),
                     .changes = "sample_flux"});
}

TEST(permeation, absorption_and_emission_agree_with_the_reference) {
  const auto overfilled = [](const Model& m, HostState& s) { overfill(m, s, 4); };
  for (const std::string keys : {"permeability: 1.0e-8", "permeability: 1.0e-8, breakthrough_pressure: 300"}) {
    SCOPED_TRACE(keys);
    compare_stage({.stage = Stage::absorption, .scene = permeable(keys), .changes = "node_liquid fluid_mass"});
    compare_stage(
        {.stage = Stage::emission, .scene = permeable(keys), .prepare = overfilled, .changes = "node_liquid"});
  }
}

namespace {

/// Σ u a of a sheet, m³/s, downwards, of what is beyond so many m/s.
double downwards(const Model& m, const HostState& s, double beyond = 0) {
  double sum = 0;
  for (std::size_t p = 0; p < s.sample_flux.size(); ++p)
    sum += (s.sample_flow_direction[p][1] < 0 ? 1 : -1) * std::max(0.0, std::fabs(s.sample_flux[p]) - beyond) *
           m.samples.area[p];
  return sum;
}

}  // namespace

TEST(permeation, liquid_on_both_sides_drives_by_the_difference_of_its_pressures) {
  for (const double low : {10e-3, 46e-3, 60e-3}) {
    const Between water(", emission_ramp: 0", low);
    const auto backend = make_kokkos_backend(water.setup.model);
    run_until(*backend, water.setup.state, Stage::permeation);
    const HostState s = backend->download();
    const double head = 50e-3 - low, expected = Between::flux(head);
    const bool passes = std::fabs(head) > 0.005;  // m: a spacing of liquid is not resolved
    ASSERT_FALSE(s.sample_flux.empty());
    int covered = 0;
    for (std::size_t p = 0; p < s.sample_flux.size(); ++p) {
      const Vec3& x = water.setup.model.samples.rest_position[p];
      if (std::max(std::fabs(x[0]), std::fabs(x[2])) > 0.01) continue;
      ++covered;
      EXPECT_NEAR(std::fabs(s.sample_flux[p]), std::fabs(expected), 50 * tolerance * std::fabs(expected));
      EXPECT_NEAR(s.sample_flow_direction[p][1], passes ? std::copysign(1 / 1.001, -head) : 0, 1e-5);
    }
    EXPECT_GT(covered, 20);
  }
}

/// Δp/τ = μ/k u + ρ β u² over more than two decades of the Reynolds number β k u/ν, from 0.03 to 22.
TEST(permeation, fast_flow_costs_its_square_by_forchheimers_law) {
  constexpr double beta = 1e7;
  std::vector<double> reynolds;
  for (const double head : {0.006, 0.02, 0.1, 1.0, 10.0, 100.0}) {  // m
    const Between water(fmt::format(", emission_ramp: 0, forchheimer: {}", beta), 50e-3, 50e-3 + head);
    const auto backend = make_kokkos_backend(water.setup.model);
    run_until(*backend, water.setup.state, Stage::permeation);
    const HostState s = backend->download();
    const double a = Between::viscosity / Between::permeability,
                 per_depth = Between::gravity * head / Between::thickness,
                 expected = (std::sqrt(a * a + 4 * beta * per_depth) - a) / (2 * beta);
    reynolds.push_back(beta * Between::permeability * expected / Between::viscosity);
    SCOPED_TRACE(fmt::format("head {} m, u = {} m/s, Re = {}", head, expected, reynolds.back()));
    int covered = 0;
    for (std::size_t p = 0; p < s.sample_flux.size(); ++p) {
      const Vec3& x = water.setup.model.samples.rest_position[p];
      if (std::max(std::fabs(x[0]), std::fabs(x[2])) > 0.01) continue;
      ++covered;
      EXPECT_NEAR(std::fabs(s.sample_flux[p]), expected, 50 * tolerance * expected);
    }
    EXPECT_GT(covered, 20);
  }
  EXPECT_LT(reynolds.front(), 0.1);
  EXPECT_GT(reynolds.back(), 10);
}

TEST(permeation, scatter_within_a_spacing_of_liquid_passes_nothing) {
  Between water(", emission_ramp: 0.02", 50e-3);
  const auto backend = make_kokkos_backend(water.setup.model);
  HostState s = water.setup.state;
  StepReport report;
  for (int k = 0; k < 40; ++k) {  // the heads differ by 8 spacings, now this way and now that way
    for (std::size_t i = 0; i < s.fluid_position.size(); ++i) {
      const double y = s.fluid_position[i][1];
      s.fluid_kappa_density[i] = Between::gravity * (50e-3 + (k % 2 == 0 && y > 0 ? 40e-3 : 0) - y);
      if (k % 2 == 1 && y < 0) s.fluid_kappa_density[i] += Between::gravity * 40e-3;
      s.fluid_kappa_divergence[i] = 0;
    }
    backend->upload(s);
    for (const Stage stage : {Stage::porous_neighbors, Stage::flow_direction, Stage::permeation})
      backend->run(stage, {k, 0, 0.001}, report);
    s = backend->download();
    for (std::size_t p = 0; p < s.sample_flux.size(); ++p) {
      const Vec3& x = water.setup.model.samples.rest_position[p];
      if (std::max(std::fabs(x[0]), std::fabs(x[2])) > 0.01) continue;
      EXPECT_EQ(s.sample_flow_direction[p][1], 0) << k;
    }
  }
}

TEST(permeation, a_fabric_that_repels_is_closed_up_to_its_breakthrough_pressure) {
  const double drop = 1000 * Between::gravity * 40e-3;  // Pa
  for (const double part : {0.5, 1.2}) {
    const Between water(fmt::format(", emission_ramp: 0, breakthrough_pressure: {:.17g}", part * drop));
    const auto backend = make_kokkos_backend(water.setup.model);
    run_until(*backend, water.setup.state, Stage::permeation);
    const HostState flow = backend->download();
    const bool open = part < 1;
    for (const Vec3& v : flow.sample_flow_direction) EXPECT_EQ(v[1] != 0, open) << "a submerged sheet emits nothing";
    run_until(*backend, water.setup.state, Stage::absorption);
    const HostState s = backend->download();
    EXPECT_EQ(sum(s.node_liquid) > sum(water.setup.state.node_liquid), open);
    EXPECT_EQ(s.fluid_mass == water.setup.state.fluid_mass, !open);
  }
}

TEST(permeation, the_flux_is_a_running_mean) {
  const Between water(", emission_ramp: 0.003");
  const auto backend = make_kokkos_backend(water.setup.model);
  StepReport report;
  backend->upload(water.setup.state);
  backend->run(Stage::porous_neighbors, {0, 0, 0.001}, report);
  double last = 0, full = 0;
  for (int k = 1; k <= 3; ++k) {
    backend->run(Stage::permeation, {0, 0, 0.001}, report);
    const double now = downwards(water.setup.model, backend->download());
    if (k == 1) full = 4 * now;  // dt/(dt + T) of it in a step
    EXPECT_NEAR(now, last + 0.25 * (full - last), 1e-5 * full) << k;
    last = now;
  }
}

TEST(permeation, what_enters_is_the_flux_and_leaves_on_the_other_side) {
  const Between water(", emission_ramp: 0");
  const Model& m = water.setup.model;
  const auto below = [](const HostState& s) {
    Quanta mass = 0;
    for (std::size_t i = 0; i < s.fluid_mass.size(); ++i)
      if (s.fluid_position[i][1] < 0) mass += s.fluid_mass[i];
    return mass;
  };
  for (const auto& backend : {make_reference_backend(m), make_kokkos_backend(m)}) {
    SCOPED_TRACE(backend->name());
    run_until(*backend, water.setup.state, Stage::absorption);
    const HostState between = backend->download();
    const double entered = double(sum(between.node_liquid) - sum(water.setup.state.node_liquid)) * m.quantum;
    const double expected = 1000 * downwards(m, between, Between::flux(0.005)) * 0.001;  // kg
    EXPECT_NEAR(entered, expected, 0.01 * expected);  // particles give an exponential's part of it
    EXPECT_EQ(below(between), below(water.setup.state));
    run_until(*backend, water.setup.state, Stage::emission);
    const HostState after = backend->download();
    EXPECT_EQ(sum(after.fluid_mass) + sum(after.node_liquid),
              sum(water.setup.state.fluid_mass) + sum(water.setup.state.node_liquid));
    EXPECT_GE(below(after), below(between));
    EXPECT_EQ(sum(after.fluid_mass) - below(after), sum(between.fluid_mass) - below(between)) << "nothing goes back up";
  }
}

}  // namespace drench::test
