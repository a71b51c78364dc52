// Water that stands on a pinned cloth: the pins carry all of it, and none comes through.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "validation.hpp"

namespace drench::test {
namespace {

constexpr double gravity = 9.81;

/// How deep (m) the deepest particle is below the sheet, which is a height field: positive is below. A particle beside
/// the sheet counts as below it.
double deepest_below(const Model& model, const HostState& s) {
  double worst = -1e9;
  for (const Vec3& x : s.fluid_position) {
    double below = 1e9;
    for (const auto& t : model.mesh.triangle) {
      const Vec3& a = s.node_position[static_cast<std::size_t>(t[0])];
      const Vec3& b = s.node_position[static_cast<std::size_t>(t[1])];
      const Vec3& c = s.node_position[static_cast<std::size_t>(t[2])];
      const double area = (b[0] - a[0]) * (c[2] - a[2]) - (c[0] - a[0]) * (b[2] - a[2]);
      const double u = ((x[0] - a[0]) * (c[2] - a[2]) - (c[0] - a[0]) * (x[2] - a[2])) / area;
      const double v = ((b[0] - a[0]) * (x[2] - a[2]) - (x[0] - a[0]) * (b[2] - a[2])) / area;
      if (u < -1e-9 || v < -1e-9 || u + v > 1 + 1e-9) continue;
      below = a[1] + u * (b[1] - a[1]) + v * (c[1] - a[1]) - x[1];
      break;
    }
    worst = std::max(worst, below);
  }
  return worst;
}

}  // namespace

TEST(cloth_pool, the_pins_carry_the_water_and_none_comes_through) {
  SceneRun run(R"(drench: 1
time: {step: 0.004, end: 5}
domain: {min: [-2, -2, -2], max: [2, 2, 2]}
fluid:
  spacing: 0.025
  viscosity: 1.0e-4
  sources: [{block: {min: [-0.075, 0, -0.075], max: [0.075, 0.05, 0.075]}}]
cloth:
  - name: sheet
    mesh: {grid: {size: [0.5, 0.5], nodes: [11, 11]}}
    areal_density: 0.2
    stretch: 400
    damping: 5
    strain_damping: 0.05
    pin: [{edges: true}]
)");
  double weight = 0;
  for (const double m : run.model().mesh.solid_mass) weight += m * gravity;
  for (const Quanta q : run.initial().fluid_mass) weight += kilograms(run.model(), q) * gravity;
  constexpr int steps = 1250, settled = 750;
  double below = -1e9, held = 0;
  int unconverged = 0;
  for (int n = 0; n < steps; ++n) {
    const StepReport r = run.step();
    ASSERT_EQ(r.particles, run.initial().fluid_count());
    const HostState s = run.state();
    below = std::max(below, deepest_below(run.model(), s));
    if (n < settled) continue;
    for (const Vec3& f : s.node_pin_force) held += f[1] / (steps - settled);
    unconverged += r.density_converged ? 0 : 1;
  }
  std::printf("pins carry %.4f of the weight; %d of %d steps at rest ended at max_iterations\n", held / weight,
              unconverged, steps - settled);
  const std::string pool = "water standing on a pinned cloth, 1.1 kg: ";
  report({pool + "pins' mean reaction of seconds 3 to 5 over the weight, − 1", "weight", std::fabs(held / weight - 1),
          0.005});
  report({pool + "lowest particle's depth below the cloth in 5 s (negative: above)", "0", below, 0, "m"});
  report({pool + "steps at rest that end at max_iterations", "1 %",
          static_cast<double>(unconverged) / (steps - settled), 0.01});
}

}  // namespace drench::test
