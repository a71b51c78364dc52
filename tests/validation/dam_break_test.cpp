// A column of water, twice as high as wide, collapses over a dry floor: Martin & Moyce 1952, base a = 2.25 in.

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
Front front(const HostState& s, int across) {
  const int deep = across / 2;
  const double spacing = base / across;
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
      c.beyond = std::max(
          c.beyond, (front(run.state(), across).farthest - base) / (2 * std::sqrt(gravity * height) * run.time()));
    }
    const double z = front(run.state(), across).median / base;
    c.z.push_back(z);
    std::printf("d = a/%d, nu %g m2/s: T %.3f: Z %.3f, measured %.3f (%+.1f %%)\n", across, viscosity, T, z, Z,
                100 * (z / Z - 1));
    c.rms += std::pow(z / Z - 1, 2) / measured.size();
  }
  c.rms = std::sqrt(c.rms);
  return c;
}

}  // namespace

TEST(dam_break, the_front_follows_the_measurements) {
  const HostState column = standing_column(12), coarse_column = standing_column(6);
  // With water's own ν the floor does not slow the front at any spacing from a/8 to a/20; ν = 1e-4 m²/s stands for it.
  const Collapse eddy = collapse(12, column, 1e-4), water = collapse(12, column, 1e-6);
  const Collapse coarse = collapse(6, coarse_column, 1e-4);
  report({"dam break, n² = 2, ν = 1e-4 m²/s, d = a/12: rms of Z", "Martin & Moyce 1952", eddy.rms, 0.08});
  report(
      {"dam break, n² = 2, ν = 1e-6 m²/s, d = a/12: rms of Z",
       "Martin & Moyce 1952",
       water.rms,
       0.08,
       "1",
       {0.137, 0.137, 0.125},
       "The boundary layer that slows the measured front is 0.5 mm thick and the spacing is 4.8 mm, so the floor does "
       "not slow the liquid."});
  report({"dam break, n² = 2, ν = 1e-4 m²/s, d = a/6: rms of Z", "Martin & Moyce 1952", coarse.rms, 0.08});
  std::printf("order of the error of Z in d: %.2f\n", std::log2(coarse.rms / eddy.rms));
  report({"dam break: front over Ritter's 2 √(gH) t, both", "Ritter 1892", std::max(eddy.beyond, water.beyond), 1});
}

}  // namespace drench::test
