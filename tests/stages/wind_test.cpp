// Stage wind: backend against reference from identical input, the drag against its law, and its keys.

#include "stages/wind.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "pipeline/pipeline.hpp"
#include "precision.hpp"
#include "scene/load.hpp"
#include "stage_compare.hpp"

namespace drench::test {
namespace {

/// Every key.
const char* const storm = R"(drench: 1
cloth: [{mesh: {grid: {size: [0.2, 0.2], nodes: [11, 11]}}}]
wind:
  velocity: [6, 1, -2]
  gusts: [{time: 0, velocity: [0, 0, 0]}, {time: 0.1, velocity: [20, 0, 5]}]
  density: 1.3
  normal_drag: 1.4
  tangential_drag: 0.1
  liquid_drag: 0.47
)";

/// A free sheet of 2 cm cells, still and in the plane y = 0.
const char* const sheet = R"(drench: 1
time: {step: 0.001, end: 10}
gravity: [0, 0, 0]
cloth: [{mesh: {grid: {size: [0.2, 0.2], nodes: [11, 11]}}, areal_density: 0.1, damping: 0}]
)";
/// Two full particles 1.5 spacings apart along x, and no gravity.
const char* const two_drops = R"(drench: 1
time: {step: 1.0e-5, end: 10}
gravity: [0, 0, 0]
fluid: {spacing: 0.01, sources: [{block: {min: [0, 0, 0], max: [0.02, 0.01, 0.01]}}]}
)";

std::string in_wind(const std::string& scene, const std::string& wind) { return scene + "wind: " + wind + "\n"; }

/// What the stage does to a state in a step of `dt`, by both backends.
template <class See>
void run_stage(const drench::Setup& setup, const HostState& start, double dt, See see) {
  std::vector<Stage> stages{Stage::wind};
  if (setup.model.has_fluid()) stages.insert(stages.begin(), Stage::neighbors);
  run_on_both(setup.model, start, stages, {0, 0, dt},
              [&](const Backend& backend, const StepReport&) { see(backend, backend.download()); });
}

bool has_stage(const std::string& scene) {
  const auto stages = stages_for(setup_from(scene).model);
  return std::find(stages.begin(), stages.end(), Stage::wind) != stages.end();
}

/// The terminal speed of a sheet that falls flat, m/s.
double terminal_speed(double areal_density, double drag) { return std::sqrt(2 * areal_density * 9.81 / (1.2 * drag)); }

}  // namespace

TEST(wind, agrees_with_the_reference) {
  for (const char* field : {"node_velocity", "fluid_velocity", "node_pin_force"}) {
    SCOPED_TRACE(field);
    compare_stage({.stage = Stage::wind,
                   .scene = wet_scene() + std::string(storm).substr(std::string(storm).find("wind:")),
                   .changes = field});
  }
}

TEST(wind, pushes_a_plate_as_its_law_says) {
  const auto setup = setup_from(in_wind(sheet, "{velocity: [3, -4, 0], normal_drag: 1.2, tangential_drag: 0.05}"));
  const double dt = 1e-6;
  run_stage(setup, setup.state, dt, [&](const Backend& backend, const HostState& s) {
    Vec3 force{0, 0, 0};
    for (std::size_t n = 0; n < s.node_velocity.size(); ++n)
      for (std::size_t a = 0; a < 3; ++a) force[a] += setup.model.mesh.solid_mass[n] * s.node_velocity[n][a] / dt;
    const double pressure = 0.5 * 1.2 * 5 * 0.04;  // ½ ρ_a |w| A, kg/s
    EXPECT_NEAR(force[0], pressure * 0.05 * 3, allowed(backend, 1e-4, 2e-4) * pressure);
    EXPECT_NEAR(force[1], pressure * 1.2 * -4, allowed(backend, 1e-3, 1e-3) * pressure);
    EXPECT_NEAR(force[2], 0, 1e-6 * pressure);
  });
}

TEST(wind, lets_a_sheet_fall_at_its_terminal_speed) {
  const std::string falling = with(sheet, "gravity: [0, 0, 0]", "gravity: [0, -9.81, 0]");
  for (const double step : {0.001, 0.02}) {
    const auto setup =
        setup_from(in_wind(with(falling, "step: 0.001", "step: " + std::to_string(step)), "{normal_drag: 1.17}"));
    const auto backend = make_kokkos_backend(setup.model);
    Pipeline pipeline(setup.model, *backend, setup.state);
    while (pipeline.time() < 1.2) pipeline.step(1);
    const HostState s = backend->download();
    double speed = 0;
    for (const Vec3& v : s.node_velocity) speed -= v[1] / double(s.node_velocity.size());
    // Splitting drag and gravity costs up to what gravity adds in half a step.
    EXPECT_NEAR(speed, terminal_speed(0.1, 1.17), 0.005 * terminal_speed(0.1, 1.17) + 0.5 * 9.81 * step) << step;
  }
}

TEST(wind, never_overshoots_the_air_whatever_the_step) {
  const auto setup = setup_from(in_wind(with(sheet, "areal_density: 0.1", "areal_density: 0.001"),
                                        "{velocity: [150, 90, -60], tangential_drag: 2}"));
  HostState start = setup.state;
  for (std::size_t n = 0; n < start.node_velocity.size(); ++n)
    for (int a = 0; a < 3; ++a) start.node_velocity[n][a] = float(40 * std::sin(12.9898 * double(n) + 78.233 * a));
  const Vec3 air{150, 90, -60};
  const auto energy = [&](const HostState& s) {
    double sum = 0;
    for (std::size_t n = 0; n < s.node_velocity.size(); ++n)
      for (std::size_t a = 0; a < 3; ++a)
        sum += setup.model.mesh.solid_mass[n] * std::pow(s.node_velocity[n][a] - air[a], 2);
    return sum;
  };
  for (const double dt : {1e-4, 1e-2, 1.0})
    run_stage(setup, start, dt, [&](const Backend&, const HostState& s) {
      EXPECT_LT(energy(s), energy(start)) << dt;
      for (const Vec3& v : s.node_velocity) EXPECT_LT(std::hypot(v[0], v[1], v[2]), 300) << dt;
    });
}

TEST(wind, drags_a_drop_as_its_law_says_and_not_one_in_its_lee) {
  const auto setup = setup_from(in_wind(two_drops, "{velocity: [5, 0, 0], liquid_drag: 0.5}"));
  ASSERT_EQ(setup.state.fluid_position.size(), 2u);
  const double dt = 1e-5, volume = 1e-6, radius = std::cbrt(3 * volume / (4 * std::numbers::pi));
  const double acceleration = 0.5 * 1.2 * 0.5 * std::numbers::pi * radius * radius * 25 / (1000 * volume);
  run_stage(setup, setup.state, dt, [&](const Backend& backend, const HostState& s) {
    const bool first = s.fluid_position[0][0] < s.fluid_position[1][0];
    const Vec3 &upwind = s.fluid_velocity[first ? 0 : 1], &lee = s.fluid_velocity[first ? 1 : 0];
    EXPECT_NEAR(upwind[0] / dt, acceleration, allowed(backend, 1e-5, 1e-4) * acceleration);
    EXPECT_NEAR(lee[0] / dt, 0, 1e-5 * acceleration);
  });
}

TEST(wind, reaches_a_drop_that_is_half_in_anothers_lee) {
  const auto setup = setup_from(in_wind(two_drops, "{velocity: [5, 0, 0], liquid_drag: 0.5}"));
  HostState state = setup.state;
  const Vec3& at = state.fluid_position[0];
  state.fluid_position[1] = {at[0] + 0.006, at[1] + 0.008, at[2]};  // the cosine is 0.6
  run_stage(setup, state, 1e-5, [&](const Backend& backend, const HostState& s) {
    EXPECT_NEAR(s.fluid_velocity[1][0], 0.4 * s.fluid_velocity[0][0],
                allowed(backend, 1e-6, 1e-4) * s.fluid_velocity[0][0]);
  });
}

TEST(wind, blows_in_gusts) {
  WindScene wind;
  wind.velocity = {1, 0, 0};
  EXPECT_EQ(wind.at(3), (Vec3{1, 0, 0}));
  EXPECT_EQ(wind.fastest(), 1);
  wind.gusts = {{1, {0, 2, 0}}, {2, {0, 4, 0}}, {4, {0, 0, 0}}};
  EXPECT_EQ(wind.at(0), (Vec3{1, 2, 0}));
  EXPECT_EQ(wind.at(1), (Vec3{1, 2, 0}));
  EXPECT_EQ(wind.at(1.5), (Vec3{1, 3, 0}));
  EXPECT_EQ(wind.at(3), (Vec3{1, 2, 0}));
  EXPECT_EQ(wind.at(9), (Vec3{1, 0, 0}));
  EXPECT_EQ(wind.fastest(), std::hypot(1, 4));
}

TEST(wind, is_a_stage_only_where_it_acts) {
  EXPECT_FALSE(has_stage(sheet));
  EXPECT_TRUE(has_stage(in_wind(sheet, "{velocity: [1, 0, 0]}")));
  EXPECT_FALSE(has_stage(in_wind(two_drops, "{velocity: [1, 0, 0]}")));
  EXPECT_TRUE(has_stage(in_wind(two_drops, "{velocity: [1, 0, 0], liquid_drag: 0.47}")));
  EXPECT_FALSE(has_stage(in_wind(with(sheet, "damping: 0", "dynamics: false"), "{velocity: [1, 0, 0]}")));
}

TEST(wind, is_read_and_saved) {
  const Scene scene = parse_scene(storm, "test.yaml");
  const WindScene& wind = scene.wind;
  EXPECT_TRUE(wind.present);
  EXPECT_EQ(wind.velocity, (Vec3{6, 1, -2}));
  ASSERT_EQ(wind.gusts.size(), 2u);
  EXPECT_EQ(wind.gusts[1], (GustScene{0.1, {20, 0, 5}}));
  EXPECT_EQ(wind.density, 1.3);
  EXPECT_EQ(wind.normal_drag, 1.4);
  EXPECT_EQ(wind.tangential_drag, 0.1);
  EXPECT_EQ(wind.liquid_drag, 0.47);
  EXPECT_EQ(parse_scene(to_yaml(scene), "saved.yaml").wind, wind);
  EXPECT_FALSE(parse_scene(sheet, "test.yaml").wind.present);
}

TEST(wind, is_refused_with_its_place) {
  const auto message = [](const std::string& wind) -> std::string {
    try {
      parse_scene(in_wind(sheet, wind), "test.yaml");
    } catch (const std::exception& e) {
      return e.what();
    }
    return "";
  };
  EXPECT_TRUE(message("{velocity: [300, 0, 0]}").starts_with("test.yaml:5:"));
  EXPECT_NE(message("{velocity: [300, 0, 0]}").find("wind.velocity"), std::string::npos);
  EXPECT_NE(message("{liquid_drag: -1}").find("wind.liquid_drag"), std::string::npos);
  EXPECT_NE(message("{gust: []}").find("did you mean 'gusts'"), std::string::npos);
  EXPECT_NE(
      message("{gusts: [{time: 1, velocity: [0, 0, 0]}, {time: 1, velocity: [0, 0, 0]}]}").find("wind.gusts.1.time"),
      std::string::npos);
}

}  // namespace drench::test
