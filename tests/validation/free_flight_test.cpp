// Liquid that nothing touches: a block flies like a stone, and a drop keeps its momentum.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "validation.hpp"

namespace drench::test {
namespace {

double length(const Vec3& v) { return std::sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]); }

Vec3 cross(const Vec3& a, const Vec3& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}

/// Momentum (kg m/s) and angular momentum about the origin (kg m²/s), and the sums of their terms' magnitudes.
struct Momentum {
  Vec3 linear{0, 0, 0}, angular{0, 0, 0};
  double linear_scale = 0, angular_scale = 0;
};

Momentum momentum(const Model& model, const HostState& s) {
  Momentum p;
  for (std::size_t i = 0; i < s.fluid_position.size(); ++i) {
    const double mass = kilograms(model, s.fluid_mass[i]);
    const Vec3 l = cross(s.fluid_position[i], s.fluid_velocity[i]);
    for (std::size_t a = 0; a < 3; ++a) {
      p.linear[a] += mass * s.fluid_velocity[i][a];
      p.angular[a] += mass * l[a];
    }
    p.linear_scale += mass * length(s.fluid_velocity[i]);
    p.angular_scale += mass * length(s.fluid_position[i]) * length(s.fluid_velocity[i]);
  }
  return p;
}

double difference(const Vec3& a, const Vec3& b) { return length({a[0] - b[0], a[1] - b[1], a[2] - b[2]}); }

}  // namespace

TEST(free_flight, a_block_falls_like_a_stone) {
  SceneRun run(R"(drench: 1
time: {step: 0.004, end: 1}
domain: {min: [-20, -20, -20], max: [20, 20, 20]}
fluid:
  spacing: 0.02
  sources: [{block: {min: [-0.1, 1, -0.1], max: [0.1, 1.2, 0.1], velocity: [1.5, 3, -0.7]}}]
)");
  constexpr int steps = 250;
  const double dt = 0.004, g = -9.81;
  double error = 0, kappa = 0, size = 0, speed = 0;
  for (int n = 1; n <= steps; ++n) {
    run.step();
    if (n % 10 != 0) continue;
    const HostState s = run.state();
    ASSERT_EQ(s.fluid_count(), run.initial().fluid_count());
    for (std::size_t i = 0; i < s.fluid_position.size(); ++i) {
      Vec3 exact = run.initial().fluid_position[i];
      for (std::size_t a = 0; a < 3; ++a) exact[a] += n * dt * run.initial().fluid_velocity[i][a];
      exact[1] += 0.5 * g * dt * dt * n * (n + 1.0);
      error = std::max(error, difference(s.fluid_position[i], exact));
      size = std::max(size, length(exact));
      speed = std::max(speed, length(s.fluid_velocity[i]));
      kappa = std::max({kappa, s.fluid_kappa_density[i], s.fluid_kappa_divergence[i]});
    }
  }
  // n additions round a position by ½ ε |x| each and a velocity by ½ ε |v|, which is carried on for T at most.
  const double bound = steps * 0.5 * rounding * (size + 0.5 * steps * dt * speed);
  report({"ballistic block, 250 steps: largest error (target: the rounding of n additions)",
          "x0 + n dt v0 + g dt² n(n+1)/2", error, bound, "m"});
  EXPECT_EQ(kappa, 0) << "m²/s²: the lattice at rest density feels pressure";
}

TEST(free_flight, a_drop_keeps_its_momentum) {
  SceneRun run(R"(drench: 1
time: {step: 0.002, end: 1}
gravity: [0, 0, 0]
domain: {min: [-20, -20, -20], max: [20, 20, 20]}
fluid:
  spacing: 0.02
  viscosity: 1.0e-4
  sources: [{block: {min: [-0.12, -0.12, -0.12], max: [0.12, 0.12, 0.12]}}]
)");
  // It drifts, turns, and falls together: the solves work in every step.
  HostState state = run.initial();
  for (std::size_t i = 0; i < state.fluid_position.size(); ++i) {
    const Vec3 x = state.fluid_position[i], turn = cross({0.5, 3, -1}, x);
    for (std::size_t a = 0; a < 3; ++a) state.fluid_velocity[i][a] = turn[a] - 2 * x[a];
    state.fluid_velocity[i][0] += 0.3;
  }
  run.restart(state);
  Momentum before = momentum(run.model(), state);
  double linear = 0, angular = 0;
  int iterations = 0;
  for (int n = 0; n < 200; ++n) {
    const StepReport r = run.step();
    iterations += r.density_iterations + r.divergence_iterations;
    const Momentum after = momentum(run.model(), run.state());
    linear = std::max(linear, difference(after.linear, before.linear) / after.linear_scale);
    angular = std::max(angular, difference(after.angular, before.angular) / after.angular_scale);
    before = after;
  }
  EXPECT_GT(iterations, 4 * 200) << "the solves have nothing to do";
  const double target = double_precision ? 1e-12 : 1e-6;
  report({"closed drop, zero g: drift of momentum per step over Σ m v", "constant", linear, target});
  report({"closed drop, zero g: drift of angular momentum per step over Σ m r v", "constant", angular, target});
}

}  // namespace drench::test
