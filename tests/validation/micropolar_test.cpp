// Spins of the liquid: their rates against the continuum, what they follow, and what they do for a vortex.

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <numbers>
#include <vector>

#include "stage_run.hpp"
#include "states.hpp"
#include "validation.hpp"

namespace drench::test {
namespace {

using std::numbers::pi;

constexpr double spacing = 0.01, transfer = 1.0e-3, spread = 4.0e-4;  // m, m²/s, m²/s

/// A block around the origin without gravity.
std::string block_scene(const Vec3& half, const std::string& keys) {
  return fmt::format(R"(drench: 1
time: {{step: 0.001, end: 10}}
gravity: [0, 0, 0]
domain: {{min: [-1, -1, -1], max: [1, 1, 1]}}
fluid:
  spacing: {}
  viscosity: 0
  micropolar: {{{}}}
  sources: [{{block: {{min: [{}, {}, {}], max: [{}, {}, {}]}}}}]
)",
                     spacing, keys, -half[0], -half[1], -half[2], half[0], half[1], half[2]);
}

/// What one step of the stage does to v_y = A sin kx with spins ω_z = B cos kx: the rates' parts along v_y/A and ω_z/B.
struct WaveRates {
  double flow = 0, spin = 0;  // m/s², 1/s²
};

WaveRates wave_rates(double wavelength, double flow, double spin, const std::string& keys) {
  const double half = wavelength / 2 + 0.04, inner = 0.02, k = 2 * pi / wavelength;
  StageRun run(block_scene({half, 0.06, 0.06}, keys));
  HostState state = run.setup.state;
  for (std::size_t i = 0; i < state.fluid_position.size(); ++i) {
    state.fluid_velocity[i] = {0, flow * std::sin(k * state.fluid_position[i][0]), 0};
    state.fluid_spin[i] = {0, 0, spin * std::cos(k * state.fluid_position[i][0])};
  }
  const StepInfo info{0, 0, 1.0e-3};
  StepReport step;
  run.backend->upload(state);
  for (const Stage stage : {Stage::neighbors, Stage::density, Stage::micropolar}) run.backend->run(stage, info, step);
  const HostState after = run.backend->download();
  WaveRates sum;
  double sines = 0, cosines = 0;
  for (std::size_t i = 0; i < state.fluid_position.size(); ++i) {
    const Vec3& x = state.fluid_position[i];
    if (std::fabs(x[0]) > wavelength / 2 || std::fabs(x[1]) > inner || std::fabs(x[2]) > inner) continue;
    const double sine = std::sin(k * x[0]), cosine = std::cos(k * x[0]);
    sum.flow += sine * (after.fluid_velocity[i][1] - state.fluid_velocity[i][1]) / info.dt;
    sum.spin += cosine * (after.fluid_spin[i][2] - state.fluid_spin[i][2]) / info.dt;
    sines += sine * sine;
    cosines += cosine * cosine;
  }
  return {sum.flow / sines, sum.spin / cosines};
}

/// Spin at the middle of a block that turns with Ω = `turn`, 1/s, after `time` of the stage alone.
double spin_after(double start, double turn, double time) {
  StageRun run(block_scene({0.05, 0.05, 0.05}, fmt::format("transfer: {}, reaction: 1", transfer)));
  HostState state = run.setup.state;
  for (std::size_t i = 0; i < state.fluid_position.size(); ++i) {
    const Vec3& x = state.fluid_position[i];
    state.fluid_velocity[i] = {-turn * x[1], turn * x[0], 0};
    state.fluid_spin[i] = {0, 0, start};
  }
  StepReport step;
  run.backend->upload(state);
  const double dt = 5.0e-4;
  for (const Stage stage : {Stage::neighbors, Stage::density}) run.backend->run(stage, {0, 0, dt}, step);
  for (double t = 0; t < time - dt / 2; t += dt) run.backend->run(Stage::micropolar, {0, 0, dt}, step);
  const HostState end = run.backend->download();
  double sum = 0, count = 0;
  for (std::size_t i = 0; i < end.fluid_position.size(); ++i) {
    const Vec3& x = end.fluid_position[i];
    if (std::fabs(x[0]) > 0.01 || std::fabs(x[1]) > 0.01 || std::fabs(x[2]) > 0.01) continue;
    sum += end.fluid_spin[i][2];
    count += 1;
  }
  return sum / count;
}

/// A drop, held together by a field, whose core turns against its shell: Σ m v_φ²/2 about its axis, J.
struct Vortex {
  double start = 0, end = 0;
};

Vortex vortex(const std::string& micropolar) {
  constexpr double radius = 0.08, rate = 12;
  SceneRun run(fmt::format(R"(drench: 1
time: {{step: 0.002, end: 10}}
gravity: [0, 0, 0]
field: {{rate: [10, 10, 10]}}
domain: {{min: [-1, -1, -1], max: [1, 1, 1]}}
fluid:
  spacing: {}
  viscosity: 1.0e-6
  {}
  sources: [{{block: {{min: [-0.08, -0.08, -0.08], max: [0.08, 0.08, 0.08]}}}}]
)",
                           spacing, micropolar));
  HostState state = run.initial();
  std::vector<std::size_t> which;
  for (std::size_t i = 0; i < state.fluid_position.size(); ++i) {
    const Vec3& x = state.fluid_position[i];
    const double turn = rate * (1 - 2 * (x[0] * x[0] + x[1] * x[1]) / (radius * radius));
    state.fluid_velocity[i] = {-turn * x[1], turn * x[0], 0};
    if (x[0] * x[0] + x[1] * x[1] + x[2] * x[2] < radius * radius) which.push_back(i);
  }
  keep_liquid(state, which);
  run.restart(state);
  const auto turning = [&](const HostState& s) {
    double sum = 0;
    for (std::size_t i = 0; i < s.fluid_position.size(); ++i) {
      const Vec3 &x = s.fluid_position[i], &v = s.fluid_velocity[i];
      const double square = x[0] * x[0] + x[1] * x[1], cross = x[0] * v[1] - x[1] * v[0];
      sum += 0.5 * kilograms(run.model(), s.fluid_mass[i]) * cross * cross / square;
    }
    return sum;
  };
  Vortex v;
  v.start = turning(state);
  while (run.time() < 0.3 - 1e-6) run.step();
  const HostState end = run.state();
  v.end = turning(end);
  return v;
}

}  // namespace

TEST(micropolar_liquid, waves_change_at_the_rates_of_the_continuum) {
  const double wavelength = 0.16, k = 2 * pi / wavelength, inertia = 2 * spacing * spacing;
  const std::string keys = fmt::format("transfer: {}, inertia: 2", transfer);
  const WaveRates by_spin = wave_rates(wavelength, 0, 50, keys), by_flow = wave_rates(wavelength, 0.5, 0, keys);
  const WaveRates pays = wave_rates(wavelength, 0.5, 0, keys + ", reaction: 1");
  const WaveRates spreads = wave_rates(wavelength, 0, 50, keys + fmt::format(", viscosity: {}", spread));
  const auto row = [](const char* what, const char* theory, double measured, double expected) {
    std::printf("%s: %.5g, expected %.5g\n", what, measured, expected);
    report({fmt::format("spins, waves of 16 d: {}", what), theory, std::fabs(measured / expected - 1), 0.05});
  };
  row("flow that spins drive", "ν_t k ω", by_spin.flow, transfer * k * 50);
  row("loss of spin", "−2 ν_t ω/Θ", by_spin.spin, -2 * transfer / inertia * 50);
  row("spin generated by the flow", "ν_t k v/Θ", by_flow.spin, transfer * k / inertia * 0.5);
  row("loss of the flow with reaction 1", "−ν_t k² v/2", pays.flow, -transfer * k * k / 2 * 0.5);
  row("spin that spreads", "−ζ k² ω", spreads.spin - by_spin.spin, -spread * k * k * 50);
  EXPECT_NEAR(by_flow.flow, 0, 1e-3 * transfer * k * k) << "it costs nothing with reaction 0";
}

TEST(micropolar_liquid, spins_follow_a_rigid_rotation) {
  const double time = spacing * spacing / (2 * transfer);  // Θ/(2 ν_t)
  report({"spins of liquid at rest: remaining spin after Θ/(2ν_t)", "1/e",
          std::fabs(spin_after(10, 0, time) / 10 * std::exp(1) - 1), 0.05});
  report({"spins in a rigid rotation Ω, without spin at first, after Θ/(2ν_t)", "Ω (1 − 1/e)",
          std::fabs(spin_after(0, 10, time) / (10 * (1 - std::exp(-1))) - 1), 0.05});
}

TEST(micropolar_liquid, a_vortex_lasts_longer) {
  const Vortex without = vortex(""), with = vortex("micropolar: {transfer: 1.0e-3}");
  std::printf("%.4g J at first, after 0.3 s %.4g J without spins, %.4g J with them\n", without.start, without.end,
              with.end);
  report({"drop with a counter-rotating core, after 0.3 s: loss of rotational energy with spins over that without",
          "below 1", (with.start - with.end) / (without.start - without.end), 0.5});
  EXPECT_LT(with.end, with.start) << "spins feed more than is lost";
  const Vortex pays = vortex("micropolar: {transfer: 1.0e-3, reaction: 1}");
  std::printf("with reaction 1 %.4g J\n", pays.end);
  EXPECT_LT(pays.end, without.end) << "winding spins up costs the flow energy";
}

}  // namespace drench::test
