// Stage evaporation: backend against reference from identical input, and both against the law.

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>

#include "pipeline/backend.hpp"
#include "precision.hpp"
#include "quanta_sum.hpp"
#include "stage_compare.hpp"

namespace drench::test {
namespace {

constexpr double rate = 0.02;  // kg/(m² s)
const std::vector<Stage> until_evaporation{Stage::neighbors, Stage::density, Stage::evaporation};

/// Water in air; `sources` and further sections.
std::string water(const std::string& sources, const std::string& more = "") {
  return fmt::format(R"(drench: 1
time: {{step: 0.001, end: 1}}
air: {{evaporation_rate: {}}}
fluid:
  spacing: 0.01
  sources: [{}]
{})",
                     rate, sources, more);
}

std::string block(double x, double y, double z) {
  return fmt::format("{{block: {{min: [0, 0, 0], max: [{}, {}, {}]}}}}", x, y, z);
}

/// What evaporates in a step of 1 ms, as an area, m², by both backends.
std::vector<double> areas(const drench::Setup& setup) {
  std::vector<double> result;
  run_on_both(setup.model, setup.state, until_evaporation, {0, 0, 0.001},
              [&](const Backend& backend, const StepReport&) {
                const HostState s = backend.download();
                EXPECT_EQ(sum(s.fluid_mass) + s.evaporated, sum(setup.state.fluid_mass));
                result.push_back(double(s.evaporated) * setup.model.quantum / (rate * 0.001));
              });
  EXPECT_NEAR(result[0], result[1], 1e-5 * result[0] + 1e-12);
  return result;
}

}  // namespace

TEST(evaporation, agrees_with_the_reference) {
  const std::string scene = with(wet_scene(), "output:", "air: {evaporation_rate: 0.02}\noutput:");
  compare_stage({.stage = Stage::evaporation, .scene = scene, .changes = "fluid_mass"});
  compare_stage({.stage = Stage::evaporation, .scene = scene, .prepare = crowd, .changes = "fluid_mass"});
  compare_stage_with_every_kernel({.stage = Stage::evaporation, .scene = scene, .changes = "fluid_mass"});
}

TEST(evaporation, a_drop_alone_is_a_ball) {
  const drench::Setup setup = setup_from(water(block(0.01, 0.01, 0.01)));
  ASSERT_EQ(setup.state.fluid_count(), 1);
  const double volume = 1e-6, expected = std::cbrt(36 * std::numbers::pi * volume * volume);
  EXPECT_NEAR(areas(setup)[0], expected, 5e-5 * expected);  // of a step's quanta one is 2.5e-5
}

TEST(evaporation, walls_are_no_surface) {
  const std::string tank = "bodies: [{box: {min: [0, 0, 0], max: [0.2, 0.3, 0.2], inside: true}}]\n";
  EXPECT_NEAR(areas(setup_from(water(block(0.2, 0.1, 0.2), tank)))[0], 0.04, 0.005 * 0.04);
  const std::string closed = "bodies: [{box: {min: [0, 0, 0], max: [0.2, 0.1, 0.2], inside: true}}]\n";
  EXPECT_NEAR(areas(setup_from(water(block(0.2, 0.1, 0.2), closed)))[0], 0, 0.01 * 0.04);
}

TEST(evaporation, gradients_that_point_inwards_count_and_kernels_agree) {
  const std::string tank = "bodies: [{box: {min: [0, 0, 0], max: [0.2, 0.3, 0.2], inside: true}}]\n";
  for (const std::string kernel : {"cubic", "wendland", "poly6"}) {
    for (const double support : {2.0, 3.0}) {
      const std::string scene = with(water(block(0.2, 0.1, 0.2), tank), "spacing: 0.01",
                                     fmt::format("spacing: 0.01\n  kernel: {}\n  support: {}", kernel, support));
      SCOPED_TRACE(scene);
      drench::Setup setup = setup_from(scene);
      const double near = (kernel == "poly6" ? 0.02 : 0.01) * 0.04;
      EXPECT_NEAR(areas(setup)[0], 0.04, near) << "lattice";
      std::mt19937 random(7);
      std::uniform_real_distribution<double> scatter(-0.0005, 0.0005);  // m
      for (auto& x : setup.state.fluid_position)
        for (double& along : x) along += scatter(random);
      EXPECT_NEAR(areas(setup)[0], 0.04, near) << "scattered; 1.05 of it if inward gradients counted as 0";
    }
  }
}

TEST(evaporation, films_and_few_particles_have_all_of_their_sides) {
  const std::string tank = "bodies: [{box: {min: [0, 0, 0], max: [0.2, 0.3, 0.2], inside: true}}]\n";
  EXPECT_NEAR(areas(setup_from(water(block(0.2, 0.01, 0.2), tank)))[0], 0.04, 0.05 * 0.04) << "one layer on a floor";
  for (const double thick : {0.01, 0.02, 0.03}) {
    const double all = 2 * 0.4 * 0.4 + 4 * 0.4 * thick;
    EXPECT_NEAR(areas(setup_from(water(block(0.4, thick, 0.4))))[0], all, 0.05 * all) << thick;
  }
  for (const int n : {2, 3, 4}) {  // in a row; as the ball that they become
    const double volume = 1e-6 * n, expected = std::cbrt(36 * std::numbers::pi * volume * volume);
    EXPECT_NEAR(areas(setup_from(water(block(0.01 * n, 0.01, 0.01))))[0], expected, 0.1 * expected) << n;
  }
}

TEST(evaporation, light_particles_on_top_hide_nothing) {
  const std::string tank = "bodies: [{box: {min: [0, 0, 0], max: [0.2, 0.3, 0.2], inside: true}}]\n";
  drench::Setup setup = setup_from(water(block(0.2, 0.1, 0.2), tank));
  for (const double part : {0.75, 0.5, 0.25, 0.1}) {
    drench::Setup light = setup;
    for (std::size_t i = 0; i < light.state.fluid_mass.size(); ++i)
      if (light.state.fluid_position[i][1] > 0.09)
        light.state.fluid_mass[i] = static_cast<Quanta>(part * double(light.state.fluid_mass[i]));
    EXPECT_NEAR(areas(light)[0], 0.04, 0.01 * 0.04) << part;
  }
}

TEST(evaporation, a_sheet_in_the_liquid_is_no_surface) {
  const std::string closed = R"(bodies: [{box: {min: [0, 0, 0], max: [0.2, 0.2, 0.2], inside: true}}]
cloth:
  - mesh: {grid: {size: [0.1, 0.1], nodes: [11, 11]}}
    place: {position: [0.1, 0.1, 0.1]}
    dynamics: false
)";
  EXPECT_NEAR(areas(setup_from(water(block(0.2, 0.2, 0.2), closed)))[0], 0, 0.05 * 2 * 0.01);
}

TEST(evaporation, the_lightest_particles_go_whole_and_at_the_right_rate) {
  drench::Setup setup = setup_from(water(block(0.1, 0.1, 0.1)));
  const Quanta least = setup.model.min_quanta;
  for (Quanta& m : setup.state.fluid_mass) m = least;
  Model any = setup.model;
  any.min_quanta = 1;
  const auto lost = [&](Backend& backend, int step) {
    StepReport report;
    backend.upload(setup.state);
    for (const Stage stage : until_evaporation) backend.run(stage, {step, 0, 1.0}, report);
    return backend.download();
  };
  const auto agrees = [&](const std::unique_ptr<Backend>& by_parts, const std::unique_ptr<Backend>& whole) {
    SCOPED_TRACE(whole->name());
    const double due = double(lost(*by_parts, 0).evaporated);
    double mean = 0;
    for (int k = 0; k < 40; ++k) {
      const HostState s = lost(*whole, k);
      for (const Quanta m : s.fluid_mass) EXPECT_TRUE(m == 0 || m == least);
      mean += double(s.evaporated) / 40;
    }
    const double drawn = mean * 40 / double(least);  // particles
    EXPECT_GT(drawn, 200);
    EXPECT_NEAR(mean, due, 4 * due / std::sqrt(drawn));
  };
  agrees(make_reference_backend(any), make_reference_backend(setup.model));
  agrees(make_kokkos_backend(any), make_kokkos_backend(setup.model));
}

TEST(evaporation, the_scene_says_how_fast) {
  const auto flux = [](const std::string& air) {
    return setup_from(with(R"(drench: 1
time: {step: 0.001, end: 1}
air: {humidity: 0.4, temperature: 25, speed: 2, length: 0.5}
fluid: {sources: [{block: {min: [0, 0, 0], max: [0.1, 0.1, 0.1]}}]}
)",
                           "{humidity: 0.4, temperature: 25, speed: 2, length: 0.5}", air))
        .model.evaporation_flux;
  };
  // by hand: ρ_sat = 0.02302 kg/m³, D_v = 2.505e-5 and ν_a = 1.552e-5 m²/s, Re = 64400, Sh = 143.7
  EXPECT_NEAR(flux("{humidity: 0.4, temperature: 25, speed: 2, length: 0.5}"), 0.0071976 * 0.6 * 0.02302, 1e-6);
  EXPECT_NEAR(flux("{humidity: 0.4, temperature: 25, transfer_coefficient: 0.01}"), 0.01 * 0.6 * 0.02302, 1e-7);
  EXPECT_EQ(flux("{evaporation_rate: 2.0e-3}"), 2e-3);
  EXPECT_EQ(flux("{humidity: 1}"), 0);
  EXPECT_GT(flux("{speed: 10, length: 10}"), 2 * flux("{speed: 2, length: 10}")) << "turbulent";
}

TEST(evaporation, advection_removes_what_is_gone) {
  drench::Setup setup = setup_from(water(block(0.05, 0.01, 0.05)));
  for (std::size_t i = 0; i < setup.state.fluid_mass.size(); ++i)
    if (i % 3 == 0) setup.state.fluid_mass[i] = setup.model.min_quanta;
  const Quanta total = sum(setup.state.fluid_mass);
  std::vector<HostState> ends;
  auto stages = until_evaporation;
  stages.push_back(Stage::advection);
  run_on_both(setup.model, setup.state, stages, {0, 0, 5.0}, [&](const Backend& backend, const StepReport& report) {
    const HostState s = backend.download();
    EXPECT_EQ(sum(s.fluid_mass) + s.evaporated + s.drained, total);
    EXPECT_EQ(s.drained, 0);
    EXPECT_EQ(report.escaped.count, 0);
    EXPECT_LT(s.fluid_count(), setup.state.fluid_count());
    for (const Quanta m : s.fluid_mass) EXPECT_GT(m, 0);
    ends.push_back(s);
  });
  EXPECT_EQ(ends[0].fluid_id, ends[1].fluid_id);
}

}  // namespace drench::test
