// The library for other programs: views of fields, what a program may change, checkpoints.

#include <gtest/gtest.h>
#include <unistd.h>

#include <cmath>
#include <cstring>
#include <filesystem>
#include <limits>
#include <memory>

#include "drench/drench.hpp"
#include "drench/prescribed.hpp"
#include "restart_scenes.hpp"
#include "same_state.hpp"
#include "setup/build.hpp"
#include "state/needed_fields.hpp"

namespace drench::test {
namespace {

namespace fs = std::filesystem;

const char* const text = R"(drench: 1
time: {step: 0.002, end: 1.0}
domain: {min: [-0.5, -0.5, -0.5], max: [0.5, 0.5, 0.5]}
fluid:
  spacing: 0.02
  sources:
    - block: {min: [-0.08, 0.03, -0.08], max: [0.08, 0.11, 0.08]}
    - jet: {center: [0, 0.3, 0], radius: 0.03, velocity: [0, -1, 0]}
cloth:
  - mesh: {grid: {size: [0.4, 0.4], nodes: [11, 11]}}
    pin: [{edges: true}, {nodes: [60]}]
    porous: {}
bodies:
  - sphere: {center: [0, -0.2, 0], radius: 0.05, dynamic: true, density: 500}
)";

Scene scene() { return parse_scene(text, "library.yaml"); }

/// Row `row`, column `column` of a view, wherever it lies.
double number(const FieldView& view, Index row, int column) {
  const std::size_t at =
      static_cast<std::size_t>(row) * static_cast<std::size_t>(view.columns) + static_cast<std::size_t>(column);
  const auto read = [&]<class T>(T) {
    std::vector<T> values(static_cast<std::size_t>(view.rows) * static_cast<std::size_t>(view.columns));
    copy_to_host(view, values.data());
    return static_cast<double>(values[at]);
  };
  switch (view.type) {
    case FieldView::Type::float32:
      return read(float{});
    case FieldView::Type::float64:
      return read(double{});
    case FieldView::Type::int64:
      return read(std::int64_t{});
    default:
      return read(std::uint8_t{});
  }
}

TEST(library, views_show_every_field_that_the_scene_needs) {
  Simulation run(scene());
  for (int k = 0; k < 3; ++k) run.step();
  const HostState state = run.state();
  std::size_t seen = 0;
  visit_fields(state, [&](std::string_view name, const auto& values) {
    if (values.empty()) return;
    ++seen;
    const FieldView view = run.field(name);
    EXPECT_EQ(static_cast<std::size_t>(view.rows), values.size()) << name;
    EXPECT_EQ(view.unit, unit_of_field(name));
    EXPECT_NE(view.data, nullptr);
    EXPECT_EQ(view.where == FieldView::Memory::host || name.starts_with("body_"),
              computes_on_host() || name.starts_with("body_"));
  });
  EXPECT_EQ(seen, run.fields().size());
  for (Index n = 0; n < state.node_count(); ++n)
    for (int a = 0; a < 3; ++a)
      EXPECT_EQ(number(run.field("node_position"), n, a),
                state.node_position[static_cast<std::size_t>(n)][static_cast<std::size_t>(a)]);
  EXPECT_EQ(number(run.field("body_position"), 0, 1), state.body_position[0][1]);
  EXPECT_EQ(number(run.field("body_orientation"), 0, 0), state.body_orientation[0][0]);
  EXPECT_THROW(run.field("fluid_colour"), std::out_of_range);
}

TEST(library, views_are_no_copies_and_outlive_the_run) {
  auto run = std::make_unique<Simulation>(scene());
  run->step();
  const FieldView first = run->field("node_velocity"), again = run->field("node_velocity");
  EXPECT_EQ(first.data, again.data);
  EXPECT_TRUE(run->is_current(first));
  const double before = number(first, 60, 1);
  EXPECT_EQ(before, number(again, 60, 1));
  run->step();
  EXPECT_FALSE(run->is_current(first));
  EXPECT_TRUE(run->is_current(run->field("node_velocity")));
  const FieldView last = run->field("fluid_position");
  const double height = number(last, 0, 1);
  run.reset();
  EXPECT_EQ(number(last, 0, 1), height);
}

TEST(library, a_view_keeps_its_memory_while_particles_come) {
  Simulation run(scene());
  const FieldView first = run.field("fluid_position");
  const std::weak_ptr<const void> memory = first.memory;
  run.set_jet(0, {0, -20, 0});
  run.run_until(0.2);
  EXPECT_GT(run.field("fluid_position").rows, 2 * first.rows);
  EXPECT_NE(run.field("fluid_position").data, first.data);
  EXPECT_FALSE(memory.expired());
  EXPECT_TRUE(std::isfinite(number(first, first.rows - 1, 2)));
}

TEST(library, goes_on_from_a_checkpoint_with_what_a_program_changed) {
  const fs::path file = fs::temp_directory_path() / ("drench_library_" + std::to_string(getpid()) + ".drench");
  Simulation run(scene());
  run.run_until(0.01);
  run.set_pin_velocity(0, 1, {0, 0.5, 0});
  run.set_jet(0, {0.2, -2, 0});
  run.set_wind({3, 0, 0});
  run.run_until(0.02);
  run.set_jet(0, {0, 0, 0});
  run.run_until(0.03);
  run.save_checkpoint(file.string());
  run.run_until(0.05);
  Simulation other(scene());
  EXPECT_TRUE(other.resume(file.string()).empty());
  other.run_until(0.05);
  expect_same(other.state(), run.state());
  fs::remove(file);
}

TEST(library, a_change_to_the_same_velocity_changes_nothing_to_speak_of) {
  Simulation run(scene()), same(scene());
  run.run_until(0.02);
  same.run_until(0.02);
  same.set_pin_velocity(0, 0, {0, 0, 0});
  same.set_jet(0, {0, -1, 0});
  run.run_until(0.1);
  same.run_until(0.1);
  const HostState a = run.state(), b = same.state();
  EXPECT_LE(std::abs(a.supplied - b.supplied),
            quanta_per_particle);  // a particle may leave a step earlier, by rounding
  for (std::size_t n = 0; n < 11; ++n) EXPECT_EQ(a.node_position[n], b.node_position[n]);
}

/// The liquid in a cup that is shaken gets its weight and the opposite of what it does to the cup.
TEST(library, moves_a_body_and_measures_what_acts_on_it) {
  const std::string text = R"(drench: 1
time: {step: 0.002, end: 1}
domain: {min: [-1, -1, -1], max: [1, 1, 1]}
fluid:
  spacing: 0.02
  sources:
    - block: {min: [-0.1, 0, -0.1], max: [0.1, 0.1, 0.1]}
bodies:
  - name: cup
    box: {min: [-0.1, 0, -0.1], max: [0.1, 0.3, 0.1], inside: true, commanded: true}
  - box: {min: [-0.1, -0.2, -0.1], max: [0.1, -0.1, 0.1]}
)";
  Simulation run(parse_scene(text, "cup"));
  const Index cup = run.body_named("cup");
  const auto momentum = [&] {
    const HostState s = run.state();
    Vec3 sum{0, 0, 0};
    for (std::size_t i = 0; i < s.fluid_mass.size(); ++i)
      for (std::size_t a = 0; a < 3; ++a)
        sum[a] += run.quantum() * static_cast<double>(s.fluid_mass[i]) * s.fluid_velocity[i][a];
    return sum;
  };
  run.set_body_velocity(cup, {0.3, 0, 0.1}, {0, 1, 0});
  run.run_until(0.1);
  const double weight = 0.2 * 0.1 * 0.2 * 1000 * 9.81;
  const Vec3 before = momentum();
  const StepReport step = run.step();
  const Vec3 after = momentum(), force = run.body_load(cup).liquid_force;
  EXPECT_LT(force[1], -0.5 * weight);
  for (std::size_t a = 0; a < 3; ++a) {
    const double given = step.dt * ((a == 1 ? -weight : 0) - force[a]);
    EXPECT_NEAR(after[a] - before[a], given, 1e-4 * step.dt * weight) << a;
  }
  EXPECT_NEAR(run.body_motion(cup).position[0], 0.3 * run.time(), 1e-9);
  run.set_body_pose(cup, {0.1, 0.2, 0}, {1, 0, 0, 0}, 0.05);
  run.run_until(run.time() + 0.06);
  EXPECT_NEAR(run.body_motion(cup).position[1], 0.2, 1e-9);
  EXPECT_THROW(run.body_named("saucer"), std::invalid_argument);
  EXPECT_THROW(run.set_body_velocity(1, {1, 0, 0}), std::invalid_argument);
  EXPECT_THROW(run.set_body_velocity(cup, {0, 1e30, 0}), std::invalid_argument);
  EXPECT_THROW(run.set_body_velocity(cup, {0, 0, 0}, {0, 1e6, 0}), std::invalid_argument);
  EXPECT_THROW(run.set_body_pose(cup, {0, 1e9, 0}, {1, 0, 0, 0}, 0.05), std::invalid_argument);
  EXPECT_THROW(run.apply_wrench(cup, {1, 0, 0}), std::invalid_argument);
  EXPECT_THROW(run.body_load(1), std::invalid_argument);
  EXPECT_THROW(run.body_motion(2), std::invalid_argument);
}

/// A sheet between two grippers weighs equally on both, by friction alone.
TEST(library, two_grippers_share_the_friction_of_the_sheet_that_they_hold) {
  Simulation run(parse_scene(R"(drench: 1
time: {step: 0.002, end: 1}
cloth:
  - mesh: {grid: {size: [0.2, 0.2], nodes: [21, 21]}}
    place: {rotate: {axis: [0, 0, 1], degrees: 90}}
    thickness: 0.002
    areal_density: 0.3
    damping: 5
bodies:
  - {name: left, box: {min: [-0.1, -0.02, -0.15], max: [-0.0008, 0.1, 0.15], commanded: true}}
  - {name: right, box: {min: [0.0008, -0.02, -0.15], max: [0.1, 0.1, 0.15], commanded: true}}
)",
                             "grippers"));
  run.run_until(0.4);
  double weight[2] = {0, 0};
  constexpr int steps = 20;
  for (int k = 0; k < steps; ++k) {
    run.step();
    for (Index b = 0; b < 2; ++b) weight[b] -= run.body_load(b).cloth_force[1] / steps;
  }
  const double whole = 0.3 * 0.04 * 9.81;
  EXPECT_NEAR(weight[0] + weight[1], whole, 0.03 * whole);
  EXPECT_NEAR(weight[0], weight[1], 0.03 * whole);
}

/// A commanded tray feels the weight of a dynamic box, and the box the same upwards.
TEST(library, bodies_in_contact_measure_what_they_do_to_each_other) {
  Simulation run(parse_scene(R"(drench: 1
time: {step: 0.002, end: 1}
domain: {min: [-0.5, -0.5, -0.5], max: [0.5, 0.5, 0.5]}
fluid:
  spacing: 0.02
  sources:
    - block: {min: [0.4, 0.4, 0.4], max: [0.44, 0.44, 0.44]}
bodies:
  - {name: tray, box: {min: [-0.2, -0.05, -0.2], max: [0.2, 0, 0.2], commanded: true}}
  - {name: load, box: {min: [-0.05, 0.001, -0.05], max: [0.05, 0.1, 0.05], dynamic: true, mass: 2}}
)",
                             "tray"));
  run.run_until(0.2);
  double tray = 0, load = 0;
  constexpr int steps = 25;
  for (int k = 0; k < steps; ++k) {
    run.step();
    tray += run.body_load(0).contact_force[1] / steps;
    load += run.body_load(1).contact_force[1] / steps;
  }
  EXPECT_NEAR(tray, -2 * 9.81, 0.01 * 2 * 9.81);
  EXPECT_NEAR(load, -tray, 1e-9);
}

TEST(library, closes_a_jet_that_moves_and_changes_nothing_else_of_it) {
  Simulation run(parse_scene(test::emitters_scene, "emitters.yaml"));
  run.run_until(0.02);
  EXPECT_THROW(run.set_jet(0, {0, -1, 0}), std::invalid_argument);
  for (const Index jet : {0, 1}) run.set_jet(jet, {0, 0, 0});
  const Quanta supplied = run.state().supplied;
  EXPECT_GT(supplied, 0);
  Simulation other(parse_scene(test::emitters_scene, "emitters.yaml"));
  other.restore(run.state(), run.changes());
  for (Simulation* each : {&run, &other}) each->run_until(0.03);
  EXPECT_EQ(run.state().supplied, supplied);
  expect_same(run.state(), other.state());
}

TEST(library, refuses_what_the_scene_does_not_have) {
  Simulation run(scene());
  const double infinite = std::numeric_limits<double>::infinity();
  EXPECT_THROW(run.set_pin_velocity(1, 0, {0, 0, 0}), std::invalid_argument);
  EXPECT_THROW(run.set_pin_velocity(0, 2, {0, 0, 0}), std::invalid_argument);
  EXPECT_THROW(run.set_pin_velocity(0, 0, {infinite, 0, 0}), std::invalid_argument);
  EXPECT_THROW(run.set_jet(1, {0, -1, 0}), std::invalid_argument);
  EXPECT_THROW(run.set_jet(0, {0, -1, 0}, Vec3{9, 0, 0}), SetupError);
  EXPECT_THROW(run.set_wind({0, infinite, 0}), std::invalid_argument);
  EXPECT_THROW(run.set_pin_velocity(0, 0, {0, 1001, 0}), std::invalid_argument);
  EXPECT_THROW(run.set_jet(0, {0, -1e30, 0}), std::invalid_argument);
  EXPECT_THROW(run.set_wind({0, 300, 0}), std::invalid_argument);
  EXPECT_THROW(run.resume("/nowhere/at_all.drench"), std::runtime_error);
  Simulation untouched(scene());
  run.run_until(0.03);
  untouched.run_until(0.03);
  expect_same(run.state(), untouched.state());
}

TEST(library, numbers_of_another_scene_are_refused) {
  const drench::Setup setup = build(scene());
  Model model = setup.model;
  change_pin_velocity(model, 0, 1, {1, 0, 0}, 0.1);
  const std::vector<double> numbers = to_numbers(model);
  Model other = setup.model;
  take_numbers(other, numbers);
  EXPECT_EQ(to_numbers(other), numbers);
  for (std::size_t length = 0; length < numbers.size(); ++length) {
    Model third = setup.model;
    EXPECT_THROW(take_numbers(third, {numbers.begin(), numbers.begin() + static_cast<std::ptrdiff_t>(length)}),
                 std::invalid_argument);
    EXPECT_EQ(to_numbers(third), to_numbers(setup.model));
  }
}

}  // namespace
}  // namespace drench::test
