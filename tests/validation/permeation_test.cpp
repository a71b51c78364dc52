// Pressure drives liquid through wet cloth: Darcy's law across the sheet (docs/theory/porous.md, section 14).

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "quanta_sum.hpp"
#include "stage_run.hpp"
#include "validation.hpp"

namespace drench::test {
namespace {

constexpr double width = 0.024, thickness = 0.001, viscosity = 1e-6, gravity = 9.81;  // m, m, m²/s, m/s²

/// A column of water on a sheet that closes a tube of 24 mm; below the sheet it falls out of the domain.
std::string column(double spacing, double height, const std::string& sheet, double end) {
  return fmt::format(R"(drench: 1
time: {{step: 0.001, end: {4}}}
domain: {{min: [-0.1, -0.06, -0.1], max: [0.1, 0.2, 0.1]}}
fluid:
  spacing: {0}
  viscosity: {5}
  sources: [{{block: {{min: [-{1}, 0, -{1}], max: [{1}, {2}, {1}]}}}}]
cloth:
  - mesh: {{grid: {{size: [{6}, {6}], nodes: [{7}, {7}]}}}}
    dynamics: false
    thickness: {8}
{3}
bodies: [{{box: {{min: [-{1}, -0.2, -{1}], max: [{1}, 0.2, {1}], inside: true}}}}]
)",
                     spacing, width / 2, height, sheet, end, viscosity, width, std::lround(width / spacing) + 1,
                     thickness);
}

/// A sheet that is wet from the start.
std::string wet(const std::string& porous) {
  return fmt::format(
      "    initial_saturation: [{{box: {{min: [-1, -1, -1], max: [1, 1, 1]}}, value: 1}}]\n    porous: {{{}}}", porous);
}

/// How much water stands above the plane of the sheet, m.
double head(const Model& m, const HostState& s) {
  double volume = 0;
  for (std::size_t i = 0; i < s.fluid_mass.size(); ++i)
    if (s.fluid_position[i][1] > 0) volume += double(s.fluid_mass[i]) * m.quantum / m.rest_density;
  return volume / (width * width);
}

Quanta all(const HostState& s) { return sum(s.fluid_mass) + sum(s.node_liquid) + s.drained; }

}  // namespace

TEST(permeation, falling_head) {
  constexpr double rate = 1;  // K, 1/s
  const double permeability = rate * viscosity * thickness / gravity;
  for (const double d : {0.004, 0.003, 0.002}) {
    SceneRun run(
        column(d, 0.03, wet(fmt::format("uptake_velocity: 0.01, diffusivity: 0, permeability: {}", permeability)), 2));
    const Quanta total = all(run.initial());
    const double start = head(run.model(), run.initial());
    double worst = 0;
    int shown = 0;
    while (run.time() < 1 / rate - 1e-9) {
      run.step();
      if (std::fabs(run.time() - 0.1 * (shown + 1)) > 5e-4) continue;
      ++shown;
      const HostState s = run.state();
      const double theory = start * std::exp(-rate * run.time()), h = head(run.model(), s);
      worst = std::max(worst, std::fabs(h / theory - 1));
      std::printf("falling head, d = %g mm: t = %.3f s, h = %.3f mm, theory %.3f mm, %d particles, cloth %.4f\n",
                  d * 1e3, run.time(), h * 1e3, theory * 1e3, int(s.fluid_count()),
                  double(sum(s.node_liquid)) * run.model().quantum / (0.6 * thickness * 1000 * width * width));
      EXPECT_EQ(all(s), total);
    }
    report({fmt::format("falling head through a wet cloth, d = {} mm: height of the water over 1/K, largest error",
                        d * 1e3),
            "h = h₀ e^(−Kt), K = k g/(ν τ)", worst, 0.05});
  }
}

namespace {

/// What passes a submerged sheet in 10 s, quanta.
struct Passing {
  Quanta capacity = 0, down_in = 0, up_in = 0, down_out = 0, up_out = 0;
};

Passing pass(const std::string& porous, const std::string& walls) {
  StageRun run(fmt::format(R"(drench: 1
time: {{step: 0.004, end: 20}}
domain: {{min: [-0.1, -0.1, -0.1], max: [0.1, 0.2, 0.1]}}
fluid:
  spacing: 0.01
  viscosity: 1.0e-4
  wall_pressure: {}
  sources: [{{block: {{min: [-0.04, 0, -0.04], max: [0.04, 0.08, 0.04]}}}}]
cloth:
  - mesh: {{grid: {{size: [0.05, 0.05], nodes: [8, 8]}}}}
    place: {{position: [0.002, 0.04, 0.001]}}
    dynamics: false
    thickness: 0.002
    porous: {{{}}}
bodies: [{{box: {{min: [-0.04, 0, -0.04], max: [0.04, 0.15, 0.04], inside: true}}}}]
)",
                           walls, porous));
  Passing p;
  const Model& m = run.setup.model;
  for (const double c : m.samples.node_capacity) p.capacity += static_cast<Quanta>(c / m.quantum);
  const auto sides = [](const HostState& s) {
    std::pair<Quanta, Quanta> mass{0, 0};
    for (std::size_t i = 0; i < s.fluid_mass.size(); ++i)
      (s.fluid_position[i][1] > 0.04 ? mass.first : mass.second) += s.fluid_mass[i];
    return mass;
  };
  while (run.time < 10 - 1e-9) {
    std::pair<Quanta, Quanta> before;
    run.step([&](Stage stage, bool done) {
      if (stage != Stage::absorption && stage != Stage::emission) return;
      const auto now = sides(run.backend->download());
      if (done && stage == Stage::absorption)
        p.down_in += before.first - now.first, p.up_in += before.second - now.second;
      if (done && stage == Stage::emission)
        p.up_out += now.first - before.first, p.down_out += now.second - before.second;
      before = now;
    });
  }
  return p;
}

}  // namespace

TEST(permeation, a_submerged_sheet_does_not_pump) {
  for (const std::string permeability : {"1e-10", "1e-9"}) {
    for (const std::string walls : {"mirrored", "extrapolated"}) {
      const Passing p = pass(fmt::format("uptake_velocity: 0.01, permeability: {}", std::stod(permeability)), walls);
      // What the sheet fills up with comes from both sides; beyond that, what leaves one side arrives on the other.
      const double unit = 1 / double(p.capacity) / 10;
      const double net = unit * double(p.down_out - p.up_out), gross = unit * double(p.down_out + p.up_out);
      std::printf("submerged, k = %s m², %s walls: downwards %.4f, upwards %.4f ΣC per second\n", permeability.c_str(),
                  walls.c_str(), unit * double(p.down_out), unit * double(p.up_out));
      const std::string which =
          fmt::format("wet cloth in a deep pool, k = {} m², {} walls, 10 s: ", permeability, walls);
      report({which + "net flux through it, ΣC per second", "0 at Δp = 0", std::fabs(net), 0.02, "1/s"});
      report({which + "release on both sides, ΣC per second", "0 at Δp = 0", gross, 0.05, "1/s"});
    }
  }
}

TEST(permeation, breakthrough) {
  // 30 mm of water, 294 Pa, on a dry sheet that repels.
  constexpr double d = 0.003, start = 0.03, rate = 1;
  const double permeability = rate * viscosity * thickness / gravity, load = 1000 * gravity * start;
  const auto sheet = [&](double breakthrough) {
    return fmt::format(
        "    porous: {{uptake_velocity: 0.01, diffusivity: 0, permeability: {}, breakthrough_pressure: {}}}",
        permeability, breakthrough);
  };
  {
    SceneRun run(column(d, start, sheet(2 * load), 2));
    const Quanta total = all(run.initial());
    while (run.time() < 1 - 1e-9) run.step();
    const HostState s = run.state();
    Quanta above = 0;
    for (std::size_t i = 0; i < s.fluid_mass.size(); ++i)
      if (s.fluid_position[i][1] > 0) above += s.fluid_mass[i];
    report({"water on a dry cloth that repels, half of its breakthrough pressure, 1 s: liquid in the cloth or below it",
            "0", double(total - above), 0, "quanta"});
  }
  SceneRun run(column(d, start, sheet(0.5 * load), 3));
  const Quanta total = all(run.initial());
  double passed_at[2]{}, heads = 0;
  int steps = 0;
  while (run.time() < 0.3 - 1e-9) {
    run.step();
    const HostState s = run.state();
    const double h = head(run.model(), s);
    if (run.time() < 0.1 - 1e-9) continue;
    if (steps == 0) passed_at[0] = h;
    passed_at[1] = h;
    heads += h;
    ++steps;
    EXPECT_EQ(all(s), total);
  }
  const double seconds = 0.001 * (steps - 1), measured = (passed_at[0] - passed_at[1]) / seconds,
               theory = rate * heads / steps;
  std::printf("breakthrough: %.4f m/s, theory %.4f, h %.4f\n", measured, theory, passed_at[1]);
  report({"the same at twice its breakthrough pressure, 0.1 to 0.3 s: flux", "k Δp/(μ τ)",
          std::fabs(measured / theory - 1), 0.1});
  while (run.time() < 1.5 - 1e-9) run.step();
  const double stays = head(run.model(), run.state());
  std::printf("breakthrough: stays %.4f m, p_b/ρg %.4f m\n", stays, 0.5 * start);
  report({"the same after 1.5 s: height of the remaining water, error", "p_b/(ρ g), to a spacing",
          std::fabs(stays - 0.5 * start) / d, 1, "spacings"});
}

}  // namespace drench::test
