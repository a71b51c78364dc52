// Steps that know their error (docs/theory/liquid.md, Eq. 27a): what they leave, beside what was asked for.

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "validation.hpp"

namespace drench::test {
namespace {

constexpr const char* falling_block = R"(drench: 1
time: {{step: 0.008, end: 1, mode: error, tolerance: {}}}
domain: {{min: [-0.5, -0.5, -0.5], max: [0.5, 0.6, 0.5]}}
output: {{every: 0}}
fluid:
  spacing: 0.02
  viscosity: 1.0e-4
  solver: {{density_correction: 1}}
  sources: [{{block: {{min: [-0.2, 0.05, -0.1], max: [0.2, 0.25, 0.1]}}}}]
cloth:
  - mesh: {{grid: {{size: [0.8, 0.8], nodes: [25, 25]}}}}
    areal_density: 0.4
    thickness: 0.002
    stretch: 4000
    pin: [{{edges: true}}]
    porous: {{}}
)";
constexpr const char* breaking_dam = R"(drench: 1
time: {{step: 0.01, end: 1, mode: error, tolerance: {}}}
domain: {{min: [0, 0, 0], max: [1, 1, 1]}}
output: {{every: 0}}
fluid:
  spacing: 0.0125
  sources: [{{block: {{min: [0, 0, 0], max: [0.2, 0.4, 0.1]}}}}]
bodies: [{{box: {{min: [0, 0, 0], max: [0.6, 0.8, 0.1], inside: true}}}}]
)";

struct Left {
  double mean = 0, worst = 0, time = 0;  // 1, 1, s
  int steps = 0, rejected = 0;
};

Left run(const char* scene, double tolerance, double end) {
  SceneRun run(fmt::format(fmt::runtime(scene), tolerance));
  Left left;
  while (run.time() < end) {
    const StepReport r = run.step(end - run.time());
    left.mean += r.density_found * r.dt;
    left.worst = std::max(left.worst, r.density_found);
    left.rejected += r.rejected;
    ++left.steps;
  }
  left.time = run.time();
  left.mean /= left.time;
  return left;
}

TEST(error_steps, leave_what_is_asked_for) {
  struct Case {
    const char *name, *scene;
    double end;  // s
    std::vector<double> tolerances;
  };
  const Case cases[] = {{"block on a pinned cloth", falling_block, 0.5, {3e-3, 1e-3, 3e-4}},
                        {"dam break", breaking_dam, 0.5, {3e-3, 1e-3}}};
  for (const auto& [name, scene, end, tolerances] : cases) {
    for (const double tolerance : tolerances) {
      const Left left = run(scene, tolerance, end);
      std::printf("%s, tolerance %g: %d steps, %d rejected; mean %.3g, worst %.3g\n", name, tolerance, left.steps,
                  left.rejected, left.mean, left.worst);
      report({fmt::format("{}, mode error, tolerance {:g}: measured compression, mean over time", name, tolerance),
              "time.tolerance", left.mean, tolerance});
      report({fmt::format("{}, mode error, tolerance {:g}: the same in the worst step", name, tolerance),
              "2.5 time.tolerance", left.worst, 2.5 * tolerance});
      EXPECT_GT(left.mean, 0.2 * tolerance) << "it does not compute what nobody asks for";
    }
  }
}

}  // namespace
}  // namespace drench::test
