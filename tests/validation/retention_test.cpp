// How fabric holds liquid against gravity: docs/theory/porous.md, Eq. 18b. Without gravity: fabric_wicking_test.cpp.

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <utility>
#include <vector>

#include "validation.hpp"

namespace drench::test {

// A strip that stands in a reservoir: sᵝ falls by 1 over the capillary height.
TEST(retention, a_strip_holds_liquid_by_its_curve_of_retention) {
  const std::vector<std::pair<double, double>> curves = {{0.5, 1}, {1, 1}, {3, 0}};
  for (const auto& [beta, n] : curves) {
    constexpr double height = 0.15, length = 0.2;
    SceneRun run(fmt::format(R"(drench: 1
time: {{step: 1, end: 1000}}
output: {{every: 0}}
cloth:
  - mesh: {{grid: {{size: [0.02, {2}], nodes: [5, 31]}}}}
    place: {{position: [0, {3}, 0], rotate: {{axis: [1, 0, 0], degrees: 90}}}}
    dynamics: false
    hold_saturation: [{{box: {{min: [-1, -1, -1], max: [1, 1.0e-6, 1]}}, value: 1}}]
    porous: {{diffusivity: 1.0e-3, diffusion_exponent: {1}, retention_exponent: {0}, capillary_height: {4}}}
)",
                             beta, n, length, length / 2, height));
    while (run.time() < 300) run.step();
    const HostState s = run.state();
    double off = 0, sum = 0;
    for (std::size_t k = 0; k < s.node_liquid.size(); ++k) {
      const double capacity = run.model().samples.node_capacity[k];
      const double left = 1 - s.node_position[k][1] / height, exact = left > 0 ? std::pow(left, 1 / beta) : 0;
      off += std::abs(kilograms(run.model(), s.node_liquid[k]) - capacity * exact);
      sum += capacity * exact;
    }
    report({fmt::format(
                "strip with a fixed-saturation boundary, β = {:g}: mean error of the saturation at rest over its mean",
                beta),
            "s = (1 − z/ℓ)^(1/β)", off / sum, 0.02});
  }
}

}  // namespace drench::test
