// Films on soaked fabric against the theory of drained plates, and where drops leave them.

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>

#include "stage_run.hpp"
#include "validation.hpp"

namespace drench::test {
namespace {

constexpr double gravity = 9.81, height = 0.3, width = 0.05, viscosity = 1e-6, density = 1000;
constexpr double thickest = 0.0003;  // m, on each face

/// A soaked strip that hangs still. Its pores keep what they hold.
std::string strip(int nodes_down, double end) {
  return fmt::format(R"(drench: 1
time: {{step: 0.004, end: {}}}
domain: {{min: [-0.2, -0.1, -0.2], max: [0.2, 0.4, 0.2]}}
fluid: {{spacing: 0.005, viscosity: 1.0e-4}}
cloth:
  - mesh: {{grid: {{size: [{}, {}], nodes: [{}, 11]}}}}
    place: {{position: [0, 0.2, 0], rotate: {{axis: [0, 0, 1], degrees: 90}}}}
    dynamics: false
    thickness: 0.001
    initial_saturation: [{{box: {{min: [-1, -1, -1], max: [1, 1, 1]}}, value: 2}}]
    porous: {{diffusivity: 1.0e-6, capillary_height: 100, film: {}, film_viscosity: {}}}
)",
                     end, height, width, nodes_down, thickest, viscosity);
}

/// Per node: thickness of the film on both faces, m.
double film_at(const Model& m, const HostState& s, std::size_t n) {
  const ClothMaterial& c = m.material_of_node(static_cast<Index>(n));
  const double saturation = double(s.node_liquid[n]) * m.quantum / m.samples.node_capacity[n];
  return (1 - c.solid_fraction) * c.thickness * std::max(0.0, saturation - 1);
}

/// ∫ δ dA over the cloth, kg.
double mass_of_film(const Model& m, const HostState& s) {
  double sum = 0;
  for (std::size_t n = 0; n < s.node_liquid.size(); ++n)
    sum += std::max(0.0, double(s.node_liquid[n]) * m.quantum - m.samples.node_capacity[n]);
  return sum;
}

/// The film's mass at a time after it began to drain, kg: δ = min(2 δ_f, 2 √(ν x/(g t))).
double drained_mass(double time) {
  const double reach = std::min(height, gravity * time * thickest * thickest / viscosity);
  const double parabola = 4.0 / 3 * std::sqrt(viscosity * std::pow(reach, 3) / (gravity * time));
  return density * width * (parabola + 2 * thickest * (height - reach));
}

void run_until(SceneRun& run, double end) {
  while (run.time() < end - 1e-9) run.step(end - run.time());
}

}  // namespace

TEST(film, drains_as_jeffreys_found) {
  SceneRun run(strip(121, 5));
  for (const double time : {1.0, 5.0}) {
    run_until(run, time);
    const HostState s = run.state();
    double worst = 0;
    for (std::size_t n = 0; n < s.node_liquid.size(); ++n) {
      const double depth = 0.35 - s.node_position[n][1];
      if (depth < 0.1 || depth > 0.25) continue;  // away from the upper edge, and from the hem where it gathers
      const double expected = 2 * std::sqrt(viscosity * depth / (gravity * time));
      worst = std::max(worst, std::abs(film_at(run.model(), s, n) / expected - 1));
    }
    report({.what = fmt::format("film of a strip of 0.3 m after {} s, largest deviation of its thickness", time),
            .reference = "2 √(ν x/(g t)), Jeffreys 1930",
            .measured = worst,
            .target = 0.05});
    report({.what = fmt::format("film of a strip of 0.3 m after {} s, deviation of its mass", time),
            .reference = "integral of Jeffreys' profile",
            .measured = std::abs(mass_of_film(run.model(), s) / drained_mass(time) - 1),
            .target = 0.05});
  }
}

TEST(film, drips_from_the_lowest_edge) {
  SceneRun run(strip(61, 2));
  Quanta low = 0, all = 0;
  std::int64_t seen = run.initial().next_id;
  while (run.time() < 2) {
    run.step();
    const HostState s = run.state();
    std::int64_t newest = seen;
    for (std::size_t i = 0; i < s.fluid_id.size(); ++i) {
      if (s.fluid_id[i] < seen) continue;
      newest = std::max<std::int64_t>(newest, s.fluid_id[i] + 1);
      all += s.fluid_mass[i];
      if (s.fluid_position[i][1] < 0.05) low += s.fluid_mass[i];
    }
    seen = newest;
  }
  report({.what = "soaked strip that hangs: share of its drops that does not leave from the lower edge",
          .reference = "film that runs down",
          .measured = all > 0 ? 1 - double(low) / double(all) : 1,
          .target = 0.2});
  double left = 0;
  for (const Quanta m : run.state().node_liquid) left += kilograms(run.model(), m);
  double before = 0;
  for (const Quanta m : run.initial().node_liquid) before += kilograms(run.model(), m);
  EXPECT_NEAR(before - left, density * width * height * 2 * thickest - drained_mass(2), 0.15 * (before - left));
}

TEST(film, under_a_level_sheet_drips_at_the_rate_of_rayleigh_and_taylor) {
  // h′ = −r h with r = ρ g² h³/(12 ν σ): h = h₀ (1 + 3 r₀ t)^(−1/3), for thin films that no node exchanges.
  constexpr double tension = 0.072, end = 1;
  SceneRun run(fmt::format(R"(drench: 1
time: {{step: 0.002, end: {}}}
domain: {{min: [-0.2, -0.3, -0.2], max: [0.2, 0.1, 0.2]}}
fluid: {{spacing: 0.004, viscosity: {}, surface_tension: {}}}
cloth:
  - mesh: {{grid: {{size: [0.2, 0.2], nodes: [41, 41]}}}}
    dynamics: false
    thickness: 0.001
    initial_saturation: [{{box: {{min: [-1, -1, -1], max: [1, 1, 1]}}, value: 2}}]
    porous: {{diffusivity: 1.0e-6, film: {}}}
)",
                           end, viscosity, tension, thickest));
  run_until(run, end);
  const HostState s = run.state();
  double film = 0, area = 0;
  for (std::size_t n = 0; n < s.node_liquid.size(); ++n) {
    const Vec3& x = s.node_position[n];
    if (std::abs(x[0]) > 0.08 || std::abs(x[2]) > 0.08) continue;
    // What has matured hangs until it is a drop: it is not the film's any more.
    const double own = run.model().samples.node_capacity[n];
    film += (double(s.node_liquid[n]) - double(s.node_buffered[n])) * run.model().quantum - own;
    area += own / (density * 0.0006);
  }
  const double h = film / (density * area) / 2;
  const double rate = density * gravity * gravity * std::pow(thickest, 3) / (12 * viscosity * tension);
  report({.what = "film under a level sheet after 1 s, deviation of its thickness",
          .reference = "growth of the fastest wave, Fermigier et al. 1992",
          .measured = std::abs(h / (thickest * std::pow(1 + 3 * rate * end, -1.0 / 3)) - 1),
          .target = 0.02});
}

}  // namespace drench::test
