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

constexpr double tolerance = double_precision ? 1e-10 : 1e-4;

std::string permeable(const std::string& keys = "permeability: 1.0e-8") {
  return with(wet_scene(), "porous: {", "porous: {" + keys + ", ");
}

/// Water on both sides of a sheet in the plane y = 0, 40 mm above it and 20 mm below, with the pressure of a head of 50 mm at the
/// sheet's upper face and of 10 mm at its lower one.
struct Between {
  static constexpr double gravity = 9.81, thickness = 0.002, viscosity = 1e-3, permeability = 1e-8;
  drench::Setup setup;

  explicit Between(const std::string& keys, double low = 10e-3)
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
      const double y = s.fluid_position[i][1], kappa = gravity * ((y > 0 ? 50e-3 : low) - y);
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
  for (const Stage s : {Stage::porous_neighbors, Stage::flow_direction, Stage::permeation, Stage::absorption, Stage::emission}) {
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
}

TEST(permeation, absorption_and_emission_agree_with_the_reference) {
  for (const std::string keys : {"permeability: 1.0e-8", "permeability: 1.0e-8, breakthrough_pressure: 300"}) {
    SCOPED_TRACE(keys);
    compare_stage({.stage = Stage::absorption, .scene = permeable(keys), .changes = "node_liquid fluid_mass"});
    compare_stage({.stage = Stage::emission, .scene = permeable(keys), .changes = "node_liquid"});
  }
}

TEST(permeation, the_flux_is_darcys) {
  for (const double low : {10e-3, 60e-3}) {
    const Between water("", low);
    const auto backend = make_kokkos_backend(water.setup.model);
    run_until(*backend, water.setup.state, Stage::permeation);
    const HostState s = backend->download();
    const double expected = Between::flux(50e-3 - low);
    ASSERT_FALSE(s.sample_flux.empty());
    for (std::size_t p = 0; p < s.sample_flux.size(); ++p) {
      const double down = s.sample_flow_direction[p][1] < 0 ? std::fabs(s.sample_flux[p]) : -std::fabs(s.sample_flux[p]);
      EXPECT_NEAR(down, expected, tolerance * std::fabs(expected));
      EXPECT_NEAR(std::fabs(s.sample_flow_direction[p][1]), 1 / 1.001, 1e-5);
    }
  }
}

TEST(permeation, a_fabric_that_repels_is_closed_up_to_its_breakthrough_pressure) {
  const double drop = 1000 * Between::gravity * 40e-3;  // Pa
  for (const double part : {0.999, 1.001}) {
    const Between water(fmt::format(", breakthrough_pressure: {:.17g}", part * drop));
    const auto backend = make_kokkos_backend(water.setup.model);
    run_until(*backend, water.setup.state, Stage::absorption);
    const HostState s = backend->download();
    const Quanta before = sum(water.setup.state.node_liquid), now = sum(s.node_liquid);
    for (const double u : s.sample_flux) EXPECT_EQ(u != 0, part < 1);
    for (const Vec3& v : s.sample_flow_direction) EXPECT_EQ(v[1] != 0, part < 1) << "a submerged sheet emits nothing";
    EXPECT_EQ(now > before, part < 1);
  }
}

TEST(permeation, what_enters_is_the_flux_and_leaves_on_the_other_side) {
  const Between water("");
  const Model& m = water.setup.model;
  for (const auto& backend : {make_reference_backend(m), make_kokkos_backend(m)}) {
    SCOPED_TRACE(backend->name());
    run_until(*backend, water.setup.state, Stage::absorption);
    const Quanta entered = sum(backend->download().node_liquid) - sum(water.setup.state.node_liquid);
    const double expected = 1000 * 0.04 * 0.04 * Between::flux(40e-3) * 0.001;  // kg
    EXPECT_NEAR(double(entered) * m.quantum, expected, 0.01 * expected);  // particles give an exponential's part of it
    run_until(*backend, water.setup.state, Stage::emission);
    const HostState after = backend->download();
    EXPECT_EQ(sum(after.fluid_mass) + sum(after.node_liquid), sum(water.setup.state.fluid_mass) + sum(water.setup.state.node_liquid));
    Quanta below = 0;
    for (std::size_t i = 0; i < after.fluid_mass.size(); ++i)
      if (after.fluid_position[i][1] < 0) below += after.fluid_mass[i];
    for (std::size_t i = 0; i < water.setup.state.fluid_mass.size(); ++i)
      if (water.setup.state.fluid_position[i][1] < 0) below -= water.setup.state.fluid_mass[i];
    EXPECT_GE(below, 0);
  }
}

}  // namespace drench::test
