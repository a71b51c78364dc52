// Stage measures: clumping and the shape of the wet patch; backend against reference and against known patterns.

#include <gtest/gtest.h>

#include <cmath>

#include "pipeline/pipeline.hpp"
#include "stage_compare.hpp"

namespace drench::test {
namespace {

constexpr const char* sheets = R"(drench: 1
time: {step: 0.002, end: 1}
output: {every: 0, measures: true}
fluid: {spacing: 0.02, sources: [{block: {min: [-0.3, 0.1, -0.3], max: [0.3, 0.2, 0.3]}}]}
cloth:
  - name: first
    mesh: {grid: {size: [0.4, 0.3], nodes: [41, 31]}}
    place: {position: [0.3, 0.1, 0], rotate: {axis: [1, 2, 3], degrees: 50}}
    porous: {}
  - {name: dry, mesh: {grid: {size: [0.1, 0.1], nodes: [5, 5]}}, place: {position: [0, 2, 0]}}
  - {name: last, mesh: {grid: {size: [0.2, 0.2], nodes: [21, 21]}}, place: {position: [0, 3, 0]}, porous: {}}
)";

/// Node (i, j) of a grid with 41 or 21 nodes a row.
std::size_t node_of(const Model& m, std::size_t cloth, Index i, Index j) {
  return static_cast<std::size_t>(m.cloths[cloth].first_node + i + j * (cloth == 0 ? 41 : 21));
}

template <class Check>
void on_both(const Model& model, const HostState& state, Check check) {
  run_on_both(model, state, {Stage::measures}, {}, [&](const Backend&, const StepReport& report) { check(report); });
}

}  // namespace

TEST(measures, agree_with_the_reference_in_a_splash) {
  const auto setup = setup_from(with(wet_scene(), "output: {every: 0}", "output: {every: 0, measures: true}"));
  const auto reference = make_reference_backend(setup.model);
  Pipeline pipeline(setup.model, *reference, setup.state);
  for (int s = 0; s < 12; ++s) pipeline.step(1.0);
  HostState state = reference->download();
  crowd(setup.model, state);
  std::vector<StepReport> reports;
  on_both(setup.model, state, [&](const StepReport& r) { reports.push_back(r); });
  EXPECT_GT(reports[0].nearest_variance, 1e-3);
  EXPECT_GT(reports[0].close_share, 0.1);
  EXPECT_GT(reports[0].wet_isotropy, 0.1);
  EXPECT_LT(reports[0].wet_isotropy, 1);
  EXPECT_NEAR(reports[1].nearest_variance, reports[0].nearest_variance, 1e-5 * reports[0].nearest_variance);
  EXPECT_EQ(reports[1].close_share, reports[0].close_share);
  EXPECT_NEAR(reports[1].wet_isotropy, reports[0].wet_isotropy, 1e-9);
}

TEST(measures, find_pairs_that_are_too_close) {
  const auto setup = setup_from(sheets);
  HostState state = setup.state;
  const double d = setup.model.spacing;
  ASSERT_EQ(setup.model.support, 2 * d);
  // Far apart from each other: two pairs, and one particle without a neighbour.
  for (std::size_t i = 0; i < state.fluid_position.size(); ++i) state.fluid_position[i] = {double(i), 0, 0};
  state.fluid_position[1] = {0.3 * d, 0, 0};
  state.fluid_position[3] = {2, 0, -1.1 * d};
  const double all = static_cast<double>(state.fluid_position.size());
  on_both(setup.model, state, [&](const StepReport& r) {
    EXPECT_NEAR(r.nearest_variance, 0.16, 1e-5);  // of 0.3, 0.3, 1.1, 1.1
    EXPECT_DOUBLE_EQ(r.close_share, 2 / all);
  });
  // A fifth of the radius each: what was too close is not any more, and at 0.09 d of each other small ones are, too.
  for (const std::size_t i : {0, 1, 2, 3}) state.fluid_mass[i] = quanta_per_particle / 125;
  on_both(setup.model, state, [&](const StepReport& r) { EXPECT_EQ(r.close_share, 0); });
  state.fluid_position[3] = {2, 0, -0.09 * d};
  on_both(setup.model, state, [&](const StepReport& r) { EXPECT_DOUBLE_EQ(r.close_share, 2 / all); });
}

TEST(measures, a_lattice_has_no_variance) {
  const auto setup = setup_from(sheets);
  on_both(setup.model, setup.state, [](const StepReport& r) {
    EXPECT_LE(r.nearest_variance, 1e-10);
    EXPECT_EQ(r.close_share, 0);
    EXPECT_EQ(r.wet_isotropy, 0) << "nothing is wet";
  });
}

TEST(measures, know_a_round_patch_from_a_long_one_however_the_cloth_lies) {
  const auto setup = setup_from(sheets);
  const Model& m = setup.model;
  HostState state = setup.state;
  // 13 × 5 nodes of one mass: the variance of n equal steps is (n² − 1)/12.
  for (Index i = 20; i < 33; ++i)
    for (Index j = 3; j < 8; ++j) state.node_liquid[node_of(m, 0, i, j)] = 1000000;
  const double strip = (25.0 - 1) / (169 - 1);
  on_both(m, state, [&](const StepReport& r) { EXPECT_NEAR(r.wet_isotropy, strip, 1e-9); });
  // A disc on the other cloth, with as much liquid as the strip has.
  Index disc = 0;
  for (const bool count : {true, false})
    for (Index i = 0; i < 21; ++i)
      for (Index j = 0; j < 21; ++j) {
        if ((i - 10) * (i - 10) + (j - 8) * (j - 8) > 36) continue;
        if (count) ++disc;
        if (!count) state.node_liquid[node_of(m, 2, i, j)] = 65 * 1000000 / disc;
      }
  on_both(m, state, [&](const StepReport& r) { EXPECT_NEAR(r.wet_isotropy, (strip + 1) / 2, 1e-6); });
  // A single node is no patch.
  HostState spot = setup.state;
  spot.node_liquid[node_of(m, 0, 7, 9)] = 12345;
  on_both(m, spot, [](const StepReport& r) { EXPECT_EQ(r.wet_isotropy, 0); });
}

}  // namespace drench::test
