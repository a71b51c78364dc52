// A standing wave in a tank swings with the period of linear theory, and decays by viscosity alone: Airy 1845; Lamb
// 1932, § 228. L is the tank's length and half a wave, H the depth.

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <numbers>
#include <vector>

#include "validation.hpp"

namespace drench::test {
namespace {

constexpr double gravity = 9.81, length = 1, depth = 0.5, wave_number = std::numbers::pi / length;  // m/s², m, m, 1/m

/// ω, 1/s.
double frequency() { return std::sqrt(gravity * wave_number * std::tanh(wave_number * depth)); }

std::string scene(int across, const std::string& walls) {
  const double d = length / across;
  return fmt::format(R"(drench: 1
time: {{step: {0}, end: 30}}
fluid:
  spacing: {1}
  viscosity: 1.0e-6
  wall_pressure: {2}
  sources: [{{block: {{min: [0, 0, 0], max: [{3}, {4}, {5}]}}}}]
bodies: [{{box: {{min: [0, 0, 0], max: [{3}, 1, {5}], inside: true}}}}]
)",
                     0.16 * d, d, walls, length, depth, 6 * d);
}

double mean_x(const HostState& s) {
  double sum = 0;
  for (const Vec3& x : s.fluid_position) sum += x[0];
  return sum / static_cast<double>(s.fluid_position.size());
}

struct Wave {
  double period = 0;     // s, between swings to the same side
  double remaining = 0;  // amplitude of the last swing over that of the one a period before it
};

/// The centre of a tank that has settled, after the flow of a flat wave whose crests rise by L/20.
Wave swing(int across, const std::string& walls) {
  SceneRun run(scene(across, walls));
  while (run.time() < 1.5) run.step();
  HostState s = run.state();
  const double omega = frequency(), begin = run.time();
  const double speed = 0.05 * length * omega / std::sinh(wave_number * depth);
  for (std::size_t i = 0; i < s.fluid_position.size(); ++i) {
    const double x = wave_number * s.fluid_position[i][0], y = wave_number * s.fluid_position[i][1];
    s.fluid_velocity[i] = {speed * std::sin(x) * std::cosh(y), -speed * std::cos(x) * std::sinh(y), 0};
  }
  run.restart(s);
  const double center = mean_x(s), theory = 2 * std::numbers::pi / omega;
  std::vector<double> zeros, most;  // times of its passages through the middle; how far it went before each
  double last = 0, last_time = begin, far = 0;
  while (run.time() < begin + 2.8 * theory) {
    run.step();
    const double now = mean_x(run.state()) - center;
    if (last != 0 && now * last < 0) {
      zeros.push_back(last_time + (run.time() - last_time) * last / (last - now));
      most.push_back(far);
      far = 0;
    }
    far = std::max(far, std::abs(now));
    last = now;
    last_time = run.time();
  }
  const std::size_t n = zeros.size();
  EXPECT_GE(n, 4u);
  // From the first passage on: four half periods, so that a drift of the middle counts for nothing.
  const Wave wave{(zeros[4] - zeros[0]) / 2, most[4] / most[2]};
  std::printf(
      "%d spacings long, %s walls: period %.4f s, theory %.4f s (%+.2f %%); a swing is %.3f of the one before\n",
      across, walls.c_str(), wave.period, theory, 100 * (wave.period / theory - 1), wave.remaining);
  return wave;
}

}  // namespace

TEST(standing_wave, swings_with_the_period_of_linear_theory) {
  for (const char* walls : {"mirrored", "extrapolated"}) {
    for (const int across : {24, 40}) {
      const Wave wave = swing(across, walls);
      report({fmt::format("standing wave, d = L/{}, {} walls: period over 2π/√(g k tanh kH), distance from 1", across,
                          walls),
              "Airy 1845", std::abs(wave.period * frequency() / (2 * std::numbers::pi) - 1), 0.03});
    }
  }
}

}  // namespace drench::test
