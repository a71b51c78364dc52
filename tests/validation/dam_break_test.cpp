// Columns of water collapse over a dry floor: one twice as high as wide (potential flow; Martin & Moyce 1952, base a
// = 2.25 in), and one behind a gate whose motion is known (Lobovský et al. 2014, 0.6 m).

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "potential_column.hpp"
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

/// Times T at which Z is compared: those of the measurement.
constexpr std::size_t times = measured.size();
using Fronts = std::array<double, times>;  // Z

double rms(const Fronts& z, const Fronts& of) {
  double sum = 0;
  for (std::size_t i = 0; i < times; ++i) sum += std::pow(z[i] / of[i] - 1, 2) / times;
  return std::sqrt(sum);
}

struct Collapse {
  Fronts z{}, late{};  // Z at the measurement's times T, and at T less the delay
  double beyond = 0;   // largest (front − a)/(2 √(gH) t)
};
Collapse collapse(int across, double delay) {
  const HostState column = standing_column(across);
  SceneRun run(scene(across, 7 * base, 1e-6));
  HostState start = run.initial();
  start.fluid_position = column.fluid_position;
  start.fluid_kappa_density = column.fluid_kappa_density;
  run.restart(start);
  Collapse c;
  const auto at = [&](double T) {
    const double until = T / std::sqrt(2 * gravity / base);
    EXPECT_LT(run.time(), until) << "times rise";
    while (run.time() < until - 1e-9) {
      run.step(until - run.time());
      c.beyond = std::max(c.beyond, (front(run.state(), base / across, across / 2).farthest - base) /
                                        (2 * std::sqrt(gravity * height) * run.time()));
    }
    return front(run.state(), base / across, across / 2).median / base;
  };
  for (std::size_t i = 0; i < times; ++i) {
    c.late[i] = at(measured[i][0] - delay);
    c.z[i] = at(measured[i][0]);
  }
  return c;
}

/// Z of potential flow at any T up to the measurement's last.
class Exact {
 public:
  explicit Exact(double finest) {
    PotentialColumn column(height / base, finest);
    for (double T = 0; T < measured.back()[0] + spacing; T += spacing) z_.push_back(column.front(T));
    EXPECT_LT(std::abs(column.growth()), 1e-3);
  }
  /// At the measurement's times less a delay.
  Fronts fronts(double delay) const {
    Fronts z{};
    for (std::size_t i = 0; i < times; ++i) {
      const double place = (measured[i][0] - delay) / spacing, left = std::floor(place);
      const auto at = static_cast<std::size_t>(left);
      z[i] = z_[at] + (place - left) * (z_[at + 1] - z_[at]);
    }
    return z;
  }

 private:
  static constexpr double spacing = 0.01;  // of T
  std::vector<double> z_;
};

Fronts measured_fronts() {
  Fronts z{};
  for (std::size_t i = 0; i < times; ++i) z[i] = measured[i][1];
  return z;
}

/// Lobovský, Botia-Vera, Castellana, Mas-Soler & Souto-Iglesias 2014 (arXiv:1308.0115): a square column behind a gate
/// that is lifted at 4.53 m/s (their median, section 4.2) from t = 0 on; the tip of the wave in Fig. 12, left, before
/// it meets the wall.
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

TEST(dam_break, the_front_follows_potential_flow_and_the_measurements) {
  const Exact flow(0.02);
  const Fronts exact = flow.fronts(0);
  EXPECT_LT(rms(Exact(0.04).fronts(0), exact), 0.005);
  // The delay with which potential flow comes nearest to the measurement: nothing of drench is in it.
  double delay = 0;
  for (double tried = 0; tried <= 0.5; tried += 0.01)
    if (rms(flow.fronts(tried), measured_fronts()) < rms(flow.fronts(delay), measured_fronts())) delay = tried;
  std::printf("potential flow: rms of Z against the measurement %.3f, with a delay of T = %.2f %.3f\n",
              rms(exact, measured_fronts()), delay, rms(flow.fronts(delay), measured_fronts()));
  const Collapse coarse = collapse(6, delay), middle = collapse(12, delay), fine = collapse(20, delay);
  for (std::size_t i = 0; i < times; ++i)
    std::printf("T %.3f: Z %.3f potential flow, %.3f measured, %.3f, %.3f, %.3f at d = a/6, a/12, a/20\n",
                measured[i][0], exact[i], measured[i][1], coarse.z[i], middle.z[i], fine.z[i]);
  report({"dam break, n² = 2, ν = 1e-6 m²/s, d = a/6: rms of Z", "potential flow", rms(coarse.z, exact), 0.05});
  report({"dam break, n² = 2, ν = 1e-6 m²/s, d = a/12: rms of Z", "potential flow", rms(middle.z, exact), 0.025});
  report({"dam break, n² = 2, ν = 1e-6 m²/s, d = a/20: rms of Z", "potential flow", rms(fine.z, exact), 0.015});
  report({"dam break, n² = 2, d = a/12: rms of Z, with the delay that fits potential flow best", "Martin & Moyce 1952",
          rms(middle.late, measured_fronts()), 0.08});
  report({"dam break, n² = 2, d = a/12: rms of Z, times as published",
          "Martin & Moyce 1952",
          rms(middle.z, measured_fronts()),
          0.08,
          "1",
          {0.17, 0.17, 0.162},
          "Potential flow misses it by 0.168, and fits it within 0.03 with a delay of 0.33 of T, 18 ms: how the column "
          "was released is not known. Behind a gate of known motion the front meets its limit."});
  report({"dam break: front over Ritter's 2 √(gH) t, all", "Ritter 1892",
          std::max({coarse.beyond, middle.beyond, fine.beyond}), 1});
}

}  // namespace drench::test
