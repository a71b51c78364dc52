// Liquid on both sides of a single layer of cloth: neither side feels the other.

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>

#include "validation.hpp"

namespace drench::test {
namespace {

constexpr double gravity = 9.81, spacing = 0.0125, depth = 0.1, gap = spacing / 4;  // m/s², m, m, m

/// Water of `above` m on a fixed sheet, and 0.1 m below it that does not quite touch it: mean pressure of the lower
/// liquid's lowest layer over its own hydrostatic one.
double pressure_below(bool through_cloth, double above) {
  SceneRun run(fmt::format(R"(drench: 1
time: {{step: 0.002, end: 1.2}}
neighbors: {{through_cloth: {0}}}
fluid:
  spacing: {1}
  viscosity: 0.01
  solver: {{density_error: 1.0e-4, divergence_error: 1.0e-4}}
  sources:
    - block: {{min: [-0.05, 0, -0.05], max: [0.05, {2}, 0.05]}}
    - block: {{min: [-0.05, {3}, -0.05], max: [0.05, {4}, 0.05]}}
cloth:
  - name: sheet
    mesh: {{grid: {{size: [0.1, 0.1], nodes: [9, 9]}}}}
    place: {{position: [0, {3}, 0]}}
    dynamics: false
bodies: [{{box: {{min: [-0.05, 0, -0.05], max: [0.05, 0.3, 0.05], inside: true}}}}]
)",
                           through_cloth, spacing, depth, depth + gap, depth + gap + above));
  while (run.time() < 0.6 - 1e-9) run.step();
  const std::size_t below = 8 * 8 * 8;
  double sum = 0;
  int count = 0;
  while (run.time() < 1.2 - 1e-9) {
    const HostState before = run.state();
    run.step();
    const HostState s = run.state();
    for (std::size_t i = 0; i < below; ++i) {
      const double y = before.fluid_position[i][1];
      if (y > spacing) continue;
      sum += (s.fluid_kappa_density[i] + s.fluid_kappa_divergence[i]) / (gravity * (depth - y));
      ++count;
    }
  }
  return sum / count;
}

}  // namespace

TEST(thin_sheet, liquid_does_not_press_through_a_single_layer_of_cloth) {
  // One layer instead of eight on the sheet for comparison: a channel of eight particles is itself 7 % off.
  const double alone = pressure_below(false, spacing);
  const double with_rule = pressure_below(false, depth) / alone, without = pressure_below(true, depth) / alone;
  std::printf("pressure below the sheet over that without water above: %.3f, without the rule %.3f\n", with_rule,
              without);
  report(
      {"0.1 m of water above and below a fixed cloth: pressure at the lower floor over that without the water above, − "
       "1",
       "equal", std::fabs(with_rule - 1), 0.02});
  EXPECT_GT(without, 1.1) << "the scene does not show what the rule is for";
}

}  // namespace drench::test
