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

// A strip whose large pores, between yarns, hold liquid up to a third of the height of the small ones.
TEST(retention, a_strip_with_pores_of_two_sizes_holds_liquid_in_each_up_to_its_height) {
  for (const double beta : {1.0, 2.0}) {
    constexpr double height = 0.15, large_height = 0.05, share = 0.6, length = 0.2;
    SceneRun run(fmt::format(R"(drench: 1
time: {{step: 1, end: 1000}}
output: {{every: 0}}
cloth:
  - mesh: {{grid: {{size: [0.02, {1}], nodes: [2, 21]}}}}
    place: {{position: [0, {2}, 0], rotate: {{axis: [1, 0, 0], degrees: 90}}}}
    dynamics: false
    hold_saturation: [{{box: {{min: [-1, -1, -1], max: [1, 1.0e-6, 1]}}, value: 1}}]
    porous: {{diffusivity: 1.0e-3, diffusion: degenerate, retention_exponent: {0}, capillary_height: {3},
             large_pores: {4}, large_pore_height: {5}}}
)",
                             beta, length, length / 2, height, share, large_height));
    while (run.time() < 80) run.step();
    const HostState s = run.state();
    const auto held = [&](double z, double up_to) { return z < up_to ? std::pow(1 - z / up_to, 1 / beta) : 0; };
    double off = 0, sum = 0;
    for (std::size_t n = 0; n < s.node_liquid.size(); ++n) {
      const double capacity = run.model().samples.node_capacity[n], z = s.node_position[n][1];
      const double exact = (1 - share) * held(z, height) + share * held(z, large_height);
      off += std::abs(kilograms(run.model(), s.node_liquid[n]) - capacity * exact);
      sum += capacity * exact;
    }
    report({fmt::format("strip with pores of two sizes, β = {:g}: mean error of the saturation at rest over its mean",
                        beta),
            "s = Σ w (1 − z/ℓ)^(1/β)", off / sum, 0.02});
  }
}

// A strip that is stretched before it is wetted: finer pores raise the liquid higher.
TEST(retention, a_stretched_strip_holds_liquid_as_high_as_its_pores_are_finer) {
  constexpr double height = 0.15, length = 0.25, narrowing = 1.5, stretch = 1.2;
  SceneRun run(fmt::format(R"(drench: 1
time: {{step: 1, end: 1000}}
output: {{every: 0}}
cloth:
  - mesh: {{grid: {{size: [0.02, {0}], nodes: [5, 51]}}}}
    place: {{position: [0, {1}, 0], rotate: {{axis: [1, 0, 0], degrees: 90}}}}
    dynamics: false
    hold_saturation: [{{box: {{min: [-1, -1, -1], max: [1, 1.0e-6, 1]}}, value: 1}}]
    porous: {{diffusivity: 1.0e-3, diffusion: degenerate, capillary_height: {2}, pore_narrowing: {3}}}
)",
                           length, length / 2, height, narrowing));
  HostState s = run.state();
  for (Vec3& x : s.node_position) x[1] *= stretch;
  run.restart(s);
  while (run.time() < 400) run.step();
  s = run.state();
  // By the weights of conduction: both directions at right angles count half of their squares' growth each.
  const double finer = 1 + narrowing * (stretch * stretch - 1) / 2;
  double off = 0, sum = 0;
  for (std::size_t n = 0; n < s.node_liquid.size(); ++n) {
    const double capacity = run.model().samples.node_capacity[n];
    const double exact = std::max(0.0, 1 - s.node_position[n][1] / (finer * height));
    off += std::abs(kilograms(run.model(), s.node_liquid[n]) - capacity * exact);
    sum += capacity * exact;
  }
  report({"strip stretched by a fifth: mean error of the saturation at rest over its mean", "s = 1 − z/(ν ℓ)",
          off / sum, 0.03});
}

// A strip in a reservoir, upright, tilted and upright again: each node has scanning curves of its own, from where it
// was.
TEST(retention, a_strip_that_is_tilted_and_raised_follows_its_scanning_curves) {
  for (const double beta : {1.0, 2.0}) {
    constexpr double height = 0.1, drained = 0.2, length = 0.18, tilted = 0.4;
    const auto wetting = [=](double h) { return h < height ? std::pow(1 - h / height, 1 / beta) : 0; };
    const auto draining = [=](double h) { return h < drained ? std::pow(1 - h / drained, 1 / beta) : 0; };
    SceneRun run(fmt::format(R"(drench: 1
time: {{step: 1, end: 10000}}
output: {{every: 0}}
cloth:
  - mesh: {{grid: {{size: [0.02, {1}], nodes: [3, 19]}}}}
    place: {{position: [0, {2}, 0], rotate: {{axis: [1, 0, 0], degrees: 90}}}}
    dynamics: false
    initial_saturation: [{{box: {{min: [-1, -1, -1], max: [1, 1, 1]}}, value: 1}}]
    hold_saturation: [{{box: {{min: [-1, -1, -1], max: [1, 1.0e-6, 1]}}, value: 1}}]
    porous: {{diffusivity: 1.0e-3, diffusion: degenerate, retention_exponent: {0}, capillary_height: {3},
             drainage_height: {4}}}
)",
                             beta, length, length / 2, height, drained));
    std::vector<double> up;  // of each node, m along the strip
    for (const Vec3& x : run.initial().node_position) up.push_back(x[1]);
    const auto rests = [&](const char* where, double share, double wait, const auto& exact) {
      HostState s = run.state();
      for (std::size_t n = 0; n < up.size(); ++n) {
        s.node_position[n][1] = share * up[n];
        s.node_position[n][2] = std::sqrt(1 - share * share) * up[n];
      }
      run.restart(s);
      const double end = run.time() + wait;
      while (run.time() < end) run.step();
      s = run.state();
      double off = 0, sum = 0;
      for (std::size_t n = 0; n < up.size(); ++n) {
        const double capacity = run.model().samples.node_capacity[n];
        off += std::abs(kilograms(run.model(), s.node_liquid[n]) - capacity * exact(up[n]));
        sum += capacity * exact(up[n]);
      }
      report({fmt::format("strip with hysteresis, β = {:g}, {}: mean error of the saturation at rest over its mean",
                          beta, where),
              "Kool & Parker 1987", off / sum, 0.03});
    };
    const auto rewetted = [&](double y) {
      return 1 - (1 - wetting(tilted * y)) * (1 - draining(y)) / std::max(1e-12, 1 - wetting(y));
    };
    rests("drained from full", 1, 300, draining);
    rests("then tilted", tilted, 300, rewetted);
    rests("then raised", 1, 300, [&](double y) { return rewetted(y) / draining(tilted * y) * draining(y); });
  }
}

}  // namespace drench::test
