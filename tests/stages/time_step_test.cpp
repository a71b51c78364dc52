// Stage time_step: fixed and CFL time steps.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "pipeline/pipeline.hpp"
#include "stage_compare.hpp"

namespace drench::test {

TEST(time_step, fixed_mode_wants_the_step_of_the_scene) {
  const auto setup = setup_from(wet_scene());
  run_on_both(setup.model, setup.state, {Stage::time_step}, {},
              [&](const Backend&, const StepReport& report) { EXPECT_DOUBLE_EQ(report.dt_wanted, 0.002); });
}

TEST(time_step, cfl_mode_bounds_the_distance_of_the_fastest_particle) {
  const auto setup = setup_from(with(wet_scene(), "{step: 0.002, end: 1.0}", "{step: 0.1, end: 1.0, mode: cfl}"));
  HostState state = setup.state;
  state.fluid_velocity[3] = {0, -8, 0};
  run_on_both(setup.model, state, {Stage::time_step}, {}, [&](const Backend&, const StepReport& report) {
    EXPECT_NEAR(report.dt_wanted, 0.4 * 0.02 / (8 + 9.81 * 0.1), 1e-8);
  });
}

TEST(time_step, the_field_counts_as_gravity_does) {
  std::string scene = with(wet_scene(), "{step: 0.002, end: 1.0}", "{step: 0.1, end: 1.0, mode: cfl}");
  scene = with(scene, "domain:", "gravity: [0, 0, 0]\nfield: {center: [1, 0, 0], rate: [4, 0, 0]}\ndomain:");
  const auto setup = setup_from(scene);
  HostState state = setup.state;
  for (Vec3& v : state.fluid_velocity) v = {0, 0, 0};
  state.fluid_position[3] = {-0.9, 0.1, 0};
  run_on_both(setup.model, state, {Stage::time_step}, {}, [&](const Backend&, const StepReport& report) {
    EXPECT_NEAR(report.dt_wanted, 0.4 * 0.02 / (16 * 1.9 * 0.1), 1e-8);
  });
}

TEST(time_step, node_speed_counts_and_the_step_has_a_floor) {
  const auto setup = setup_from(with(wet_scene(), "{step: 0.002, end: 1.0}", "{step: 0.1, end: 1.0, mode: cfl}"));
  HostState state = setup.state;
  state.node_velocity[40] = {300, 0, 0};
  run_on_both(setup.model, state, {Stage::time_step}, {}, [&](const Backend&, const StepReport& report) {
    EXPECT_NEAR(report.dt_wanted, 1e-4, 1e-10);  // 0.4 d / 300 m/s is below step / 1000
  });
}

TEST(time_step, capillary_waves_bound_the_step_in_cfl_mode) {
  const std::string cfl = with(wet_scene(), "{step: 0.002, end: 1.0}", "{step: 0.1, end: 1.0, mode: cfl}");
  const std::string tense = with(cfl, "  viscosity: 1.0e-3\n", "  viscosity: 1.0e-3\n  surface_tension: 2\n");
  const std::string sticky = with(cfl, "radius: 0.05}", "radius: 0.05, adhesion: 3}");
  const double d = 0.02;
  for (const auto& [scene, strongest] : {std::pair{tense, 2.0}, std::pair{sticky, 3.0}}) {
    const auto setup = setup_from(with(scene, "domain:", "gravity: [0, 0, 0]\ndomain:"));
    HostState state = setup.state;
    std::fill(state.fluid_velocity.begin(), state.fluid_velocity.end(), Vec3{0, 0, 0});
    run_on_both(setup.model, state, {Stage::time_step}, {}, [&](const Backend&, const StepReport& report) {
      EXPECT_NEAR(report.dt_wanted, 0.7 * std::sqrt(1000 * d * d * d / (2 * 3.14159265358979 * strongest)), 1e-9);
    });
  }
}

TEST(time_step, resets_the_pin_forces) {
  const auto setup = setup_from(wet_scene());
  HostState state = setup.state;
  std::fill(state.node_pin_force.begin(), state.node_pin_force.end(), Vec3{1, 2, 3});
  run_on_both(setup.model, state, {Stage::time_step}, {}, [&](const Backend& backend, const StepReport&) {
    for (const Vec3& f : backend.download().node_pin_force) EXPECT_EQ(f, (Vec3{0, 0, 0}));
  });
}

TEST(time_step, a_step_cut_to_microseconds_throws_no_liquid) {
  const auto setup = setup_from(R"(drench: 1
time: {step: 0.002, end: 1}
domain: {min: [-0.5, -0.5, -0.5], max: [0.5, 0.5, 0.5]}
fluid: {spacing: 0.02, sources: [{block: {min: [-0.1, -0.2, -0.1], max: [0.1, -0.1, 0.1]}}]}
bodies: [{box: {min: [-0.1, -0.2, -0.1], max: [0.1, 0.3, 0.1], inside: true}}]
)");
  for (const auto& backend : {make_reference_backend(setup.model), make_kokkos_backend(setup.model)}) {
    Pipeline pipeline(setup.model, *backend, setup.state);
    double before = 0;
    for (int k = 0; k < 50; ++k) before = std::max(before, pipeline.step(1).fluid_speed);
    for (const double cut : {1e-4, 1e-5, 1e-6, 1e-8}) {
      const StepReport report = pipeline.step(cut);
      EXPECT_DOUBLE_EQ(report.dt, cut);
      EXPECT_LT(report.fluid_speed, 1.2 * before) << backend->name() << ", " << cut << " s";
    }
  }
}

TEST(time_step, a_step_cut_to_a_microsecond_throws_no_layers_apart) {
  const auto setup = setup_from(R"(drench: 1
time: {step: 0.002, end: 1}
gravity: [0, 0, 0]
domain: {min: [-1, -1, -1], max: [1, 1, 1]}
cloth:
  - {mesh: {grid: {size: [0.2, 0.2], nodes: [6, 6]}}, thickness: 0.002, self_collision: true}
  - name: upper
    mesh: {grid: {size: [0.2, 0.2], nodes: [6, 6]}}
    place: {position: [0.013, 0.001, 0.007]}
    thickness: 0.002
    self_collision: true
)");
  for (const auto& backend : {make_reference_backend(setup.model), make_kokkos_backend(setup.model)}) {
    Pipeline pipeline(setup.model, *backend, setup.state);
    const double cut = pipeline.step(1e-6).cloth_speed, whole = pipeline.step(1).cloth_speed;
    EXPECT_GT(whole, 0.02) << backend->name();
    EXPECT_LT(cut, 2.1 * whole) << backend->name();
  }
}

TEST(time_step, a_step_cut_to_a_microsecond_throws_no_body) {
  // Boxes that rest on each other and on a floor, a little too deep.
  const auto setup = setup_from(R"(drench: 1
time: {step: 0.002, end: 1}
domain: {min: [-1, -1, -1], max: [1, 1, 1]}
fluid: {spacing: 0.02, sources: [{block: {min: [0.6, 0, 0.6], max: [0.62, 0.02, 0.62]}}]}
bodies:
  - {plane: {point: [0, 0, 0], normal: [0, 1, 0]}}
  - {box: {min: [-0.05, -0.0003, -0.05], max: [0.05, 0.0997, 0.05], dynamic: true, density: 500}}
  - {box: {min: [-0.05, 0.0994, -0.05], max: [0.05, 0.1994, 0.05], dynamic: true, density: 500}}
)");
  for (const auto& backend : {make_reference_backend(setup.model), make_kokkos_backend(setup.model)}) {
    Pipeline pipeline(setup.model, *backend, setup.state);
    pipeline.step(1e-6);
    for (const Vec3& v : backend->download().body_velocity) EXPECT_LT(std::fabs(v[1]), 0.3) << backend->name();
  }
}

}  // namespace drench::test
