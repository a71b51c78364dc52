// Columns of water collapse over a dry floor: one twice as high as wide (Martin & Moyce 1952, base a = 2.25 in), and one behind
// a gate whose motion is known (Lobovský et al. 2014, 0.6 m).

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "validation.hpp"

namespace drench::test {
namespace {

constexpr double gravity = 9.81, base = 2.25 * 0.0254, height = 2 * base;  // m/s², m
constexpr double width = base / 2;                                         // of the channel, m
constexpr std::array<std::array<double, 2>, 6> measured{
    {{0.832, 1.217}, {1.219, 1.474}, {1.997, 2.292}, {2.547, 2.995}, {3.345, 4.134}, {4.034, 4.944}}};  // T, Z

/// `across`: particles in the base.
std::string scene(int across, double length, double viscosity) {
  return fmt::format(R"(drench: 1
time: {{step: 0.002, end: 1, mode: cfl}}
fluid:
  spacing: {0}
  viscosity: {1}
  sources: [{{block: {{min: [0, 0, 0], max: [{2}, {3}, {4}]}}}}]
bodies: [{{box: {{min: [0, 0, 0], max: [{5}, {6}, {4}], inside: true}}}}]
)",
                     base / across, viscosity, base, height, width, length, 1.5 * height);
}

/// The column at rest behind its gate, as in the experiment: a lattice that was cut out has no pressure yet.
HostState standing_column(int across) {
  SceneRun gate(scene(across, base, 1e-3));
  while (gate.time() < 0.6) gate.step();
  return gate.state();
}

/// Where the front stands, m: of the farthest particles of the rows along the channel the median, so that no single
/// spray particle counts as the front; and the farthest of all.
struct Front {
  double median = 0, farthest = 0;
};
Front front(const HostState& s, double spacing, int deep) {
  std::vector<double> row(std::size_t(deep), 0);
  for (const Vec3& x : s.fluid_position) {
    double& far = row[static_cast<std::size_t>(std::clamp(static_cast<int>(x[2] / spacing), 0, deep - 1))];
    far = std::max(far, x[0] + 0.5 * spacing);
  }
  std::sort(row.begin(), row.end());
  return {0.5 * (row[std::size_t(deep / 2)] + row[std::size_t((deep - 1) / 2)]), row.back()};
}

struct Collapse {
  double rms = 0;         // of Z against the measurements, relative
  double beyond = 0;      // largest (front − a)/(2 √(gH) t)
  std::vector<double> z;  // Z at the measurements' times
};
Collapse collapse(int across, const HostState& column, double viscosity) {
  SceneRun run(scene(across, 7 * base, viscosity));
  HostState start = run.initial();
  start.fluid_position = column.fluid_position;
  start.fluid_kappa_density = column.fluid_kappa_density;
  run.restart(start);
  Collapse c;
  for (const auto& [T, Z] : measured) {
    const double until = T / std::sqrt(2 * gravity / base);
    while (run.time() < until - 1e-9) {
      run.step(until - run.time());
      c.beyond = std::max(c.beyond, (front(run.state(), base / across, across / 2).farthest - base) /
                                        (2 * std::sqrt(gravity * height) * run.time()));
    }
    const double z = front(run.state(), base / across, across / 2).median / base;
    c.z.push_back(z);
    std::printf("d = a/%d, nu %g m2/s: T %.3f: Z %.3f, measured %.3f (%+.1f %%)\n", across, viscosity, T, z, Z,
                100 * (z / Z - 1));
    c.rms += std::pow(z / Z - 1, 2) / measured.size();
  }
  c.rms = std::sqrt(c.rms);
  return c;
}

/// Lobovský, Botia-Vera, Castellana, Mas-Soler & Souto-Iglesias 2014 (arXiv:1308.0115): a square column behind a gate that is
/// lifted at 4.53 m/s (their median, section 4.2) from t = 0 on; the tip of the wave in Fig. 12, left, before it meets the wall.
namespace gated {

constexpr double side = 0.6, tank = 1.61, lift = 4.53, opens = 1;  // m, m, m/s, s
constexpr std::array<std::array<double, 2>, 8> tip{{{0.512, 1.411},
                                                    {0.674, 1.558},
                                                    {0.808, 1.689},
                                                    {1.011, 1.904},
                                                    {1.199, 2.144},
                                                    {1.307, 2.282},
                                                    {1.402, 2.412},
                                                    {1.509, 2.562}}};  // t √(g/H), front over H

std::string scene(int across) {
  const double d = side / across;
  return fmt::format(R"(drench: 1
time: {{step: 0.004, end: 2, mode: cfl}}
fluid:
  spacing: {0}
  viscosity: 1.0e-6
  sources: [{{block: {{min: [0, 0, 0], max: [{1}, {1}, {2}]}}}}]
bodies:
  - box: {{min: [0, 0, 0], max: [{3}, {4}, {2}], inside: true}}
  - box: {{min: [{1}, 0, 0], max: [{5}, {6}, {2}],
      offset: [[{7}, [0, 0, 0]], [{8}, [0, {9}, 0]]]}}
)",
                     d, side, 6 * d, tank, 2 * side, side + d, 1.2 * side, opens, opens + 1, lift);
}

/// rms of the front against the measurements, relative.
double collapse(int across) {
  SceneRun run(scene(across));
  double sum = 0;
  for (const auto& [T, Z] : tip) {
    const double until = opens + T / std::sqrt(gravity / side);
    while (run.time() < until - 1e-9) run.step(until - run.time());
    const double z = front(run.state(), side / across, 6).median / side;
    std::printf("gate, d = a/%d: T %.3f: Z %.3f, measured %.3f (%+.1f %%)\n", across, T, z, Z, 100 * (z / Z - 1));
    sum += std::pow(z / Z - 1, 2) / tip.size();
  }
  return std::sqrt(sum);
}

}  // namespace gated

}  // namespace

TEST(dam_break, the_front_behind_a_gate_follows_the_measurements) {
  const double fine = gated::collapse(20), coarse = gated::collapse(12);
  report({"dam break behind a gate, ν = 1e-6 m²/s, d = a/20: rms of the front", "Lobovský et al. 2014", fine, 0.08});
  report({"dam break behind a gate, ν = 1e-6 m²/s, d = a/12: rms of the front", "Lobovský et al. 2014", coarse, 0.08});
}

TEST(dam_break, the_front_follows_the_measurements) {
  const HostState column = standing_column(12), coarse_column = standing_column(6);
  // At this size, with water's own ν, the floor does not slow the front at any spacing from a/8 to a/20; ν = 1e-4 m²/s stands for it.
  const Collapse eddy = collapse(12, column, 1e-4), water = collapse(12, column, 1e-6);
  const Collapse coarse = collapse(6, coarse_column, 1e-4);
  report({"dam break, n² = 2, ν = 1e-4 m²/s, d = a/12: rms of Z", "Martin & Moyce 1952", eddy.rms, 0.08});
  report(
      {"dam break, n² = 2, ν = 1e-6 m²/s, d = a/12: rms of Z",
       "Martin & Moyce 1952",
       water.rms,
       0.08,
       "1",
       {0.17, 0.17, 0.162},
       "The column is let go at once, and leads by a tenth from the start; later no floor slows it, for the boundary "
       "layer is 0.5 mm thick and the spacing 4.8 mm. Behind a gate whose motion is known the front is met."});
  report({"dam break, n² = 2, ν = 1e-4 m²/s, d = a/6: rms of Z", "Martin & Moyce 1952", coarse.rms, 0.08});
  std::printf("order of the error of Z in d: %.2f\n", std::log2(coarse.rms / eddy.rms));
  report({"dam break: front over Ritter's 2 √(gH) t, both", "Ritter 1892", std::max(eddy.beyond, water.beyond), 1});
}

}  // namespace drench::test
