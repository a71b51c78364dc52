// Stage ledger: the account of every quantum; backend against reference.

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numeric>

#include "pipeline/backend.hpp"
#include "stage_compare.hpp"

namespace drench::test {

TEST(ledger, counts_every_quantum) {
  const auto setup = setup_from(wet_scene());
  HostState state = setup.state;
  for (std::size_t i = 0; i < state.fluid_mass.size(); ++i) state.fluid_mass[i] -= static_cast<Quanta>(i * 7919 + 1);
  state.drained = 12345;
  state.supplied = 54321;
  state.evaporated = 999;
  const Quanta fluid = std::accumulate(state.fluid_mass.begin(), state.fluid_mass.end(), Quanta{0});
  const Quanta cloth = std::accumulate(state.node_liquid.begin(), state.node_liquid.end(), Quanta{0});
  ASSERT_GT(cloth, 0);
  run_on_both(setup.model, state, {Stage::ledger}, {}, [&](const Backend&, const StepReport& report) {
    EXPECT_EQ(report.mass_fluid, fluid);
    EXPECT_EQ(report.mass_cloth, cloth);
    EXPECT_EQ(report.mass_total(), fluid + cloth + 12345 + 999 - 54321);
    EXPECT_NEAR(report.mass_float, static_cast<double>(fluid + cloth) * setup.model.quantum, 1e-6 * report.mass_float);
    EXPECT_EQ(report.nonfinite, 0);
    EXPECT_EQ(report.particles, static_cast<std::int64_t>(state.fluid_mass.size()));
  });
}

TEST(ledger, energy_and_saturation_agree_with_the_reference) {
  const auto setup = setup_from(wet_scene());
  StepReport reports[2];
  int k = 0;
  run_on_both(setup.model, setup.state, {Stage::ledger}, {},
              [&](const Backend&, const StepReport& report) { reports[k++] = report; });
  EXPECT_GT(reports[0].kinetic_energy, 0);
  EXPECT_NEAR(reports[1].kinetic_energy, reports[0].kinetic_energy, 1e-6 * reports[0].kinetic_energy);
  EXPECT_NEAR(reports[0].saturation_max, 1.1, 1e-6);
  EXPECT_NEAR(reports[1].saturation_max, reports[0].saturation_max, 1e-12);
}

TEST(ledger, counts_what_is_not_finite) {
  const auto setup = setup_from(wet_scene());
  HostState state = setup.state;
  state.fluid_position[5][1] = std::numeric_limits<double>::quiet_NaN();
  state.fluid_velocity[9][0] = std::numeric_limits<double>::infinity();
  state.node_velocity[2][2] = std::numeric_limits<double>::quiet_NaN();
  run_on_both(setup.model, state, {Stage::ledger}, {},
              [&](const Backend&, const StepReport& report) { EXPECT_EQ(report.nonfinite, 3); });
}

}  // namespace drench::test
