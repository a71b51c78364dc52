// Stage advection: backend against reference from identical input.

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <functional>

#include "pipeline/backend.hpp"
#include "stage_compare.hpp"

namespace drench::test {

TEST(advection, agrees_with_the_reference) { compare_stage({.stage = Stage::advection, .changes = "fluid_position"}); }

TEST(advection, fast_particles_stopped_at_the_cloth_agree_with_the_reference) {
  compare_stage({.stage = Stage::advection,
                 .prepare =
                     [](const Model&, HostState& s) {
                       for (std::size_t i = 0; i < s.fluid_velocity.size(); i += 3)
                         s.fluid_velocity[i] = {0.3, -12, 0.2};
                     },
                 .changes = "node_velocity"});
}

TEST(advection, coincident_particles_part_as_in_the_reference) {
  compare_stage({.stage = Stage::advection,
                 .prepare =
                     [](const Model&, HostState& s) {
                       for (std::size_t i = 0; i + 2 < s.fluid_position.size(); i += 9) {
                         s.fluid_position[i + 1] = s.fluid_position[i];
                         s.fluid_velocity[i + 1] = s.fluid_velocity[i];
                         s.fluid_position[i + 2] = s.fluid_position[i];
                         s.fluid_position[i + 2][0] += 4e-6;
                       }
                     },
                 .changes = "fluid_position"});
}

TEST(advection, no_particle_passes_an_unbroken_cloth) {
  const auto setup =
      setup_from(with(wet_scene(), "pin: [{edges: true}]", "pin: [{box: {min: [-1, -1, -1], max: [1, 1, 1]}}]"));
  HostState state = setup.state;
  for (Vec3& v : state.fluid_velocity) v = {0, -40, 0};  // four spacings a step
  run_on_both(setup.model, state, until_advection, {0, 0, 0.002}, [](const Backend& backend, const StepReport& report) {
    EXPECT_GT(report.collisions, 50);
    for (const Vec3& x : backend.download().fluid_position) EXPECT_GT(x[1], 0);
  });
}

TEST(advection, what_a_sheet_stops_slides_on_along_it) {
  // A floor and a wall that meet at x = 0.05 m. The way along them is kept, also in their corner, and so is that
  // velocity.
  const drench::Setup setup = setup_from(R"(drench: 1
gravity: [0, 0, 0]
domain: {min: [-1, -1, -1], max: [1, 1, 1]}
fluid:
  spacing: 0.01
  sources: [{block: {min: [-0.005, 0.1, -0.005], max: [0.015, 0.11, 0.015]}}]
cloth:
  - mesh: {grid: {size: [0.2, 0.2], nodes: [11, 11]}}
    place: {position: [-0.05, 0, 0]}
    dynamics: false
  - name: wall
    mesh: {grid: {size: [0.2, 0.2], nodes: [11, 11]}}
    place: {position: [0.05, 0.1, 0], rotate: {axis: [0, 0, 1], degrees: 90}}
    dynamics: false
)");
  constexpr double dt = 0.002, gap = 1e-4;  // s; m
  struct Case {
    const char* name;
    Vec3 start, velocity, end, left;
  };
  const Case cases[] = {
      {"floor", {-0.05, 0.001, 0}, {3, -1, 0.5}, {-0.044, gap, 0.001}, {3, 0, 0.5}},
      {"fast", {-0.05, 0.001, 0}, {20, -20, 0}, {-0.01, gap, 0}, {20, 0, 0}},
      {"wall", {0.049, 0.05, 0}, {1, 3, 0}, {0.05 - gap, 0.056, 0}, {0, 3, 0}},
      {"corner", {0.045, 0.005, 0}, {5, -5, 1}, {0.05 - gap, gap, 0.002}, {0, 0, 1}},
  };
  HostState s = setup.state;
  ASSERT_EQ(s.fluid_count(), 4);
  for (std::size_t i = 0; i < 4; ++i) {
    s.fluid_position[i] = cases[i].start;
    s.fluid_velocity[i] = cases[i].velocity;
  }
  run_on_both(setup.model, s, until_advection, {0, 0, dt}, [&](const Backend& backend, const StepReport& report) {
    EXPECT_EQ(report.collisions, 4);
    const HostState end = backend.download();
    for (std::size_t i = 0; i < 4; ++i)
      for (std::size_t a = 0; a < 3; ++a) {
        EXPECT_NEAR(end.fluid_position[i][a], cases[i].end[a], 1e-7) << cases[i].name << ", axis " << a;
        EXPECT_NEAR(end.fluid_velocity[i][a], cases[i].left[a], 1e-5) << cases[i].name << ", axis " << a;
      }
  });
}

TEST(advection, pins_hold_against_what_a_sheet_stops) {
  const drench::Setup setup =
      setup_from(with(wet_scene(), "pin: [{edges: true}]", "pin: [{box: {min: [-1, -1, -1], max: [1, 1, 1]}}]"));
  constexpr double dt = 0.002;
  HostState s = setup.state;
  for (Vec3& v : s.fluid_velocity) v = {1, -12, 0.3};
  for (Vec3& f : s.node_pin_force) f = {0, 0, 0};
  const auto momentum = [&](const HostState& state, std::size_t a) {
    double sum = 0;
    for (std::size_t i = 0; i < state.fluid_velocity.size(); ++i)
      sum += setup.model.quantum * static_cast<double>(state.fluid_mass[i]) * state.fluid_velocity[i][a];
    return sum;
  };
  run_on_both(setup.model, s, until_advection, {0, 0, dt}, [&](const Backend& backend, const StepReport& report) {
    EXPECT_GT(report.collisions, 30);
    const HostState end = backend.download();
    ASSERT_EQ(end.fluid_count(), s.fluid_count());
    for (std::size_t a = 0; a < 3; ++a) {
      double held = 0;
      for (const Vec3& f : end.node_pin_force) held += dt * f[a];
      const double whole = std::fabs(momentum(s, 1));
      EXPECT_NEAR(held, momentum(end, a) - momentum(s, a), 1e-6 * whole) << "axis " << a;
      if (a == 1) {
        EXPECT_GT(held, 0.1 * whole);
      }
    }
  });
}

TEST(advection, what_leaves_the_domain_enters_the_account_of_drained_liquid) {
  compare_stage({.stage = Stage::advection,
                 .steps_before = 3,
                 .prepare =
                     [](const Model&, HostState& s) {
                       for (std::size_t i = 0; i < s.fluid_velocity.size(); i += 5) s.fluid_velocity[i] = {900, 0, 0};
                     },
                 .changes = "fluid_mass"});
}

/// A box, a ball and the half-space below a plane, which the block and the jet reach into.
constexpr const char* drains = R"(
  drains:
    - {box: {min: [-0.05, 0, -0.04], max: [0, 0.05, 0.02]}}
    - {sphere: {center: [0.05, 0.1, 0.03], radius: 0.03}, end: 0.5}
    - {plane: {point: [0.03, 0.2, 0], normal: [-1, -0.4, 0.2]}}
    - {box: {min: [-1, -1, -1], max: [1, 1, 1]}, start: 0.5}
cloth:)";

TEST(advection, what_a_drain_takes_enters_the_account_of_drained_liquid) {
  compare_stage({.stage = Stage::advection,
                 .scene = with(wet_scene(), "\ncloth:", drains),
                 .steps_before = 2,
                 .prepare =
                     [](const Model&, HostState& s) {
                       for (std::size_t i = 0; i < s.fluid_velocity.size(); i += 7) s.fluid_velocity[i] = {900, 0, 0};
                     },
                 .changes = "fluid_mass"});
}

TEST(advection, a_drain_takes_while_it_is_open_and_is_no_alarm) {
  const drench::Setup setup = setup_from(R"(drench: 1
gravity: [0, 0, 0]
fluid:
  spacing: 0.02
  sources: [{block: {min: [0, 0, 0], max: [0.2, 0.2, 0.2], concentration: 0.01}}]
  drains: [{plane: {point: [0, 0.1, 0], normal: [0, 1, 0]}, start: 0.5, end: 0.7}]
)");
  const Quanta half = 500 * quanta_per_particle;
  for (const auto& [time, taken] : std::vector<std::pair<double, Quanta>>{{0.4, 0}, {0.5, half}, {0.6, half}, {0.7, 0}})
    run_on_both(setup.model, setup.state, until_advection, {0, time - 0.001, 0.001, 1},
                [&](const Backend& backend, const StepReport& report) {
                  const HostState s = backend.download();
                  EXPECT_EQ(s.drained, taken) << time;
                  EXPECT_EQ(s.solute_drained, taken) << time;
                  EXPECT_EQ(s.fluid_count(), taken > 0 ? 500 : 1000) << time;
                  EXPECT_EQ(report.escaped.count, 0);
                });
}

/// In single precision -0.3 is less than -0.3.
TEST(advection, liquid_at_walls_on_the_border_of_the_domain_stays) {
  for (const char* bodies :
       {"[{box: {min: [-0.3, -0.1, -0.4], max: [0.3, 0.7, 0.4], inside: true}}]",
        "[{plane: {point: [-0.3, 0, 0], normal: [1, 0, 0]}}, {plane: {point: [0.3, 0, 0], normal: "
        "[-1, 0, 0]}}, {plane: {point: [0, -0.1, 0], normal: [0, 1, 0]}}, {plane: {point: [0, 0.7, "
        "0], normal: [0, -1, 0]}}, {plane: {point: [0, 0, -0.4], normal: [0, 0, 1]}}, {plane: "
        "{point: [0, 0, 0.4], normal: [0, 0, -1]}}]"}) {
    SCOPED_TRACE(bodies);
    const drench::Setup setup = setup_from(fmt::format(R"(drench: 1
domain: {{min: [-0.3, -0.1, -0.4], max: [0.3, 0.7, 0.4]}}
fluid:
  spacing: 0.05
  sources: [{{block: {{min: [-0.3, -0.1, -0.4], max: [0.3, 0.7, 0.4]}}}}]
bodies: {}
)",
                                                       bodies));
    HostState state = setup.state;
    for (std::size_t i = 0; i < state.fluid_velocity.size(); ++i)
      state.fluid_velocity[i][i % 3] = i % 2 == 0 ? 100 : -100;
    run_on_both(setup.model, state, until_advection, {0, 0, 0.01, 1}, [&](const Backend& backend, const StepReport& r) {
      EXPECT_GT(r.clamped, 1000);
      EXPECT_EQ(backend.download().drained, 0);
    });
  }
}

/// One step of the stages around advection, on both backends: law 6 and 7's numbers are the ledger's.
void expect_alike(const drench::Setup& setup, const HostState& state, const StepInfo& info,
                  const std::function<void(const StepReport&)>& expect) {
  for (const auto& backend : {make_reference_backend(setup.model), make_kokkos_backend(setup.model)}) {
    SCOPED_TRACE(backend->name());
    backend->upload(state);
    for (const bool again : {false, true}) {  // the second begins anew, with nothing left of the first
      if (again) backend->upload(setup.state);
      StepReport report;
      for (const Stage stage : {Stage::neighbors, Stage::density, Stage::advection, Stage::ledger})
        backend->run(stage, info, report);
      if (!again) {
        expect(report);
        continue;
      }
      EXPECT_EQ(report.tunnelled, 0);
      EXPECT_EQ(report.lowest_tunnelled, -1);
      EXPECT_EQ(report.escaped.count, 0);
    }
  }
}

TEST(advection, what_two_sheets_leave_behind_them_is_counted) {
  const drench::Setup setup = setup_from(R"(drench: 1
gravity: [0, 0, 0]
domain: {min: [-1, -1, -1], max: [1, 1, 1]}
fluid:
  spacing: 0.01
  sources: [{block: {min: [-0.035, 0.005, -0.035], max: [0.035, 0.015, 0.035]}}]
cloth:
  - mesh: {grid: {size: [0.2, 0.2], nodes: [11, 11]}}
  - name: upper
    mesh: {grid: {size: [0.2, 0.2], nodes: [11, 11]}}
    place: {position: [0, 0.02, 0]}
)");
  HostState s = setup.state;
  ASSERT_EQ(s.fluid_count(), 49);
  for (std::size_t n = 0; n < s.node_velocity.size(); ++n) s.node_velocity[n] = {0, n < 121 ? 30.0 : -30.0, 0};
  for (std::int64_t& id : s.fluid_id) id += 1000;
  expect_alike(setup, s, {0, 0, 0.002}, [](const StepReport& report) {
    EXPECT_EQ(report.tunnelled, 49);
    EXPECT_EQ(report.lowest_tunnelled, 1000);
  });
}

TEST(advection, what_a_body_pushes_through_a_sheet_is_counted) {
  const drench::Setup setup = setup_from(R"(drench: 1
gravity: [0, 0, 0]
domain: {min: [-1, -1, -1], max: [1, 1, 1]}
fluid:
  spacing: 0.01
  sources: [{block: {min: [-0.035, 0.05, -0.035], max: [0.035, 0.06, 0.035]}}]
cloth:
  - mesh: {grid: {size: [0.2, 0.2], nodes: [11, 11]}}
    place: {position: [0, 0.01, 0]}
    dynamics: false
bodies:
  - box: {min: [-0.09, -0.1, -0.09], max: [0.09, 0, 0.09], velocity: [0, 5, 0]}
)");
  HostState s = setup.state;
  for (std::size_t i = 0; i < s.fluid_position.size(); ++i) s.fluid_position[i][1] = i % 7 == 0 ? 0.05 : 0.004;
  // The box's top is at 0.015 at the end: 42 particles are put there, 7 are far above.
  expect_alike(setup, s, {0, 0, 0.003}, [&](const StepReport& report) {
    EXPECT_EQ(report.clamped, 42);
    EXPECT_EQ(report.tunnelled, 42);
    EXPECT_EQ(report.lowest_tunnelled, s.fluid_id.at(1));
  });
}

TEST(advection, who_leaves_the_domain_at_once_or_too_fast_is_named) {
  const drench::Setup setup = setup_from(wet_scene());
  ASSERT_GE(setup.state.fluid_count(), 100);
  const auto speed_all = [&](double speed, std::size_t every) {
    HostState s = setup.state;
    for (std::size_t i = 0; i < s.fluid_velocity.size(); i += every) s.fluid_velocity[i] = {0, 0, speed};
    return s;
  };
  expect_alike(setup, speed_all(4000, 1), {0, 0, 0.002}, [&](const StepReport& report) {
    EXPECT_EQ(report.escaped.count, setup.state.fluid_count());
    EXPECT_EQ(report.escaped.lowest, (std::array<std::int64_t, 8>{0, 1, 2, 3, 4, 5, 6, 7}));
    EXPECT_NEAR(report.escaped_speed, 4000, 1);
  });
  expect_alike(setup, speed_all(4000, 50), {0, 0, 0.002}, [](const StepReport& report) {
    EXPECT_EQ(report.escaped.count, 0) << "a few, and nobody has said how fast is too fast";
    EXPECT_NEAR(report.escaped_speed, 4000, 1);
  });
  expect_alike(setup, speed_all(4000, 50), {0, 0, 0.002, 3000}, [&](const StepReport& report) {
    EXPECT_EQ(report.escaped.count, (setup.state.fluid_count() + 49) / 50);
    EXPECT_EQ(report.escaped.lowest[1], 50);
  });
}

TEST(advection, stops_particles_at_the_nodes_of_a_stretched_sheet) {
  // A triangle's nodes are the points farthest from its samples, and stretching takes them farther still.
  const drench::Setup setup = setup_from(R"(drench: 1
time: {step: 0.002, end: 1}
domain: {min: [-1, -1, -1], max: [1, 1, 1]}
fluid:
  spacing: 0.01
  sources: [{block: {min: [-0.045, 0.1, -0.045], max: [0.045, 0.11, 0.045]}}]
cloth:
  - mesh: {grid: {size: [0.2, 0.2], nodes: [11, 11]}}
    pin: [{edges: true}]
)");
  for (const double stretch : {1.0, 1.3, 2.0}) {
    SCOPED_TRACE(stretch);
    HostState s = setup.state;
    std::vector<Vec3> over;
    for (std::size_t n = 0; n < s.node_position.size(); ++n) {
      if (!setup.model.mesh.pinned[n]) over.push_back(s.node_position[n]);
    }
    ASSERT_EQ(over.size(), 81u);
    ASSERT_EQ(s.fluid_count(), 81);
    for (Vec3& x : s.node_position) x = {stretch * x[0], x[1], stretch * x[2]};
    for (std::size_t i = 0; i < over.size(); ++i) {
      s.fluid_position[i] = {stretch * over[i][0], 1e-4, stretch * over[i][2]};
      s.fluid_velocity[i] = {0, -2, 0};
    }
    run_on_both(setup.model, s, until_advection, {0, 0, 0.002}, [](const Backend& backend, const StepReport& report) {
      EXPECT_EQ(report.collisions, 81);
      for (const Vec3& x : backend.download().fluid_position) EXPECT_GT(x[1], 0);
    });
  }
}

}  // namespace drench::test
