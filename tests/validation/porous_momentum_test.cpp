// Liquid and porous cloth exchange mass, and its momentum goes along. How much and how fast: porous_exchange_test.cpp.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "quanta_sum.hpp"
#include "stage_run.hpp"
#include "validation.hpp"

namespace drench::test {
namespace {

struct Momentum {
  Vec3 sum{0, 0, 0};  // kg m/s
  double size = 0;    // Σ m|v|

  Momentum(const Model& m, const HostState& s) {
    const auto add = [&](double mass, const Vec3& v) {
      for (std::size_t c = 0; c < 3; ++c) sum[c] += mass * v[c];
      size += mass * std::hypot(v[0], v[1], v[2]);
    };
    for (std::size_t i = 0; i < s.fluid_mass.size(); ++i) add(double(s.fluid_mass[i]) * m.quantum, s.fluid_velocity[i]);
    for (std::size_t n = 0; n < s.node_liquid.size(); ++n)
      add(m.mesh.solid_mass[n] + double(s.node_liquid[n]) * m.quantum, s.node_velocity[n]);
  }
};

/// Largest component of b − a, over Σ m|v|.
double drift(const Momentum& a, const Momentum& b) {
  double worst = 0;
  for (std::size_t c = 0; c < 3; ++c) worst = std::max(worst, std::fabs(b.sum[c] - a.sum[c]) / a.size);
  return worst;
}

/// As if a stage had moved mass alone.
HostState without_momentum(const HostState& before, HostState after) {
  after.node_velocity = before.node_velocity;
  return after;
}

/// Runs steps and calls seen(stage, before, after) with the states around each stage; the largest drift of a step.
template <class Seen>
double run_and_watch(StageRun& run, int steps, Seen&& seen) {
  const Model& m = run.setup.model;
  double worst = 0;
  HostState last = run.backend->download();
  for (int n = 0; n < steps; ++n) {
    const Momentum first(m, last);
    run.step([&](Stage stage, bool done) {
      if (!done) return;
      HostState now = run.backend->download();
      seen(stage, last, now);
      last = std::move(now);
    });
    worst = std::max(worst, drift(first, Momentum(m, last)));
  }
  return worst;
}

const double momentum_bound = double_precision ? 1e-12 : 1e-6;

}  // namespace

TEST(porous_exchange, momentum_goes_with_liquid_between_layers) {
  // A soaked sheet slides and turns over a dry one of another weave, 1 mm below it; no gravity.
  StageRun run(R"(drench: 1
time: {step: 0.002, end: 10}
gravity: [0, 0, 0]
cloth_solver: {method: xpbd}
cloth:
  - mesh: {grid: {size: [0.12, 0.12], nodes: [13, 13]}}
    thickness: 0.002
    damping: 0
    porous: {contact_wicking: true, diffusivity: 1.0e-5}
  - name: upper
    mesh: {grid: {size: [0.1, 0.1], nodes: [12, 9]}}
    place: {position: [-0.01, 0.001, 0.003]}
    thickness: 0.002
    damping: 0
    initial_saturation: [{box: {min: [-1, -1, -1], max: [1, 1, 1]}, value: 1}]
    porous: {contact_wicking: true, solid_fraction: 0.7, diffusivity: 2.0e-5}
)");
  const Model& m = run.setup.model;
  HostState start = run.setup.state;
  for (std::size_t n = 0; n < start.node_velocity.size(); ++n) {
    const Vec3& x = start.node_position[n];
    if (m.mesh.node_cloth[n] == 1) start.node_velocity[n] = {0.2 + 2 * x[2], 0, 0.05 - 2 * x[0]};
  }
  run.backend->upload(start);
  double diffusion = 0, spread = 0;
  const double step = run_and_watch(run, 60, [&](Stage stage, const HostState& before, const HostState& after) {
    if (stage != Stage::diffusion) return;
    diffusion = std::max(diffusion, drift({m, before}, {m, after}));
    spread = std::max(spread, drift({m, before}, {m, without_momentum(before, after)}));
  });
  const std::vector<Quanta> end = run.backend->download().node_liquid;
  Quanta passed = 0;
  for (std::size_t n = 0; n < end.size(); ++n) passed += m.mesh.node_cloth[n] == 0 ? end[n] : 0;
  const double share = double(passed) / double(sum(end));
  std::printf("momentum between layers: %.3f of the liquid passed; without its momentum %.1e a step\n", share, spread);
  EXPECT_GT(share, 0.1);
  EXPECT_GT(spread, 1e-6);
  const std::string what = "soaked cloth that slides over a dry one, contact_wicking: change of Σmv ";
  report({what + "by stage diffusion, over its magnitudes' sum", "0", diffusion, momentum_bound});
  report({what + "in a step (xpbd), over its magnitudes' sum", "0", step, momentum_bound});
}

TEST(porous_exchange, momentum_goes_with_the_mass) {
  // Liquid flies into one half of a free sheet whose other half is overfull and drips. Within it liquid spreads.
  // Gravity is only there to tell the emission where to; its own momentum is 1e-8 of the liquid's a step.
  const double bound = momentum_bound;
  StageRun run(R"(drench: 1
time: {step: 0.002, end: 10}
gravity: [0, -1.0e-12, 0]
domain: {min: [-1, -1, -1], max: [1, 1, 1]}
fluid:
  spacing: 0.01
  viscosity: 1.0e-4
  sources: [{block: {min: [-0.05, 0.002, -0.03], max: [0, 0.052, 0.04], velocity: [0.1, -0.5, 0.05]}}]
cloth_solver: {method: xpbd}
cloth:
  - mesh: {grid: {size: [0.12, 0.12], nodes: [13, 13]}}
    thickness: 0.002
    damping: 0
    initial_saturation: [{box: {min: [-1, -1, -1], max: [1, 1, 1]}, value: 1.15},
                         {box: {min: [-1, -1, -1], max: [0, 1, 1]}, value: 0}]
    porous: {uptake_velocity: 0.05, diffusivity: 1.0e-4}
)");
  const Model& m = run.setup.model;
  double absorption = 0, emission = 0, diffusion = 0, taken = 0, given = 0, spread = 0;
  const double step = run_and_watch(run, 60, [&](Stage stage, const HostState& before, const HostState& after) {
    const double change = drift({m, before}, {m, after});
    const double gain = double(sum(after.node_liquid) - sum(before.node_liquid)) / double(quanta_per_particle);
    if (stage == Stage::absorption) {
      absorption = std::max(absorption, change);
      taken += gain;
    } else if (stage == Stage::emission) {
      emission = std::max(emission, change);
      given -= gain;
    } else if (stage == Stage::diffusion) {
      diffusion = std::max(diffusion, change);
      spread = std::max(spread, drift({m, before}, {m, without_momentum(before, after)}));
    }
  });
  std::printf("momentum: %.2f particles taken up, %.2f given back; diffusion without its momentum %.1e\n", taken, given,
              spread);
  EXPECT_GT(spread, 1e-6);
  EXPECT_GT(taken, 5);
  EXPECT_GT(given, 1);
  const std::string what = "free cloth that absorbs and releases, no gravity: change of Σmv ",
                    over = ", over its magnitudes' sum";
  report({what + "by stage absorption" + over, "0", absorption, bound});
  report({what + "by stage emission" + over, "0", emission, bound});
  report({what + "by stage diffusion" + over, "0", diffusion, bound});
  report({what + "in a step (xpbd)" + over, "0", step, bound});
}

}  // namespace drench::test
