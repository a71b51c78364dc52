// Stage cloth: backend against reference from identical input.

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <functional>

#include "cloth/solver.hpp"
#include "cloth_scenes.hpp"
#include "drench/prescribed.hpp"
#include "pipeline/pipeline.hpp"
#include "pipeline/runtime.hpp"
#include "precision.hpp"
#include "stage_compare.hpp"

namespace drench::test {
namespace {

/// The scene with strain damping and the other method.
std::string xpbd_scene() {
  return with(with(wet_scene(), "cloth:\n", "cloth_solver: {method: xpbd}\ncloth:\n"),
              "    pin:", "    strain_damping: 0.003\n    pin:");
}

/// With a strain limit, and a solve that goes on long enough for both to end at the same place.
std::string limited(const std::string& scene) {
  const std::string tight = scene.find("cloth_solver") == std::string::npos
                                ? with(scene, "cloth:\n", "cloth_solver: {tolerance: 1.0e-5}\ncloth:\n")
                                : with(scene, "method: xpbd", "method: xpbd, tolerance: 1.0e-5");
  return with(tight, "thickness: 0.002", "thickness: 0.002\n    strain_limit: 0.02");
}

void stretch_and_compress(const Model& m, HostState& s) {
  for (std::size_t n = 0; n < s.node_position.size(); ++n) {
    if (m.mesh.pinned[n]) continue;
    s.node_position[n][0] += 0.006 * std::sin(40 * s.node_position[n][0]);
    s.node_position[n][1] += 0.004 * std::cos(70 * s.node_position[n][2]);
  }
}

/// Taut, pins and all, so that the step has one solution.
void stretch_and_shear(const Model&, HostState& s) {
  for (Vec3& x : s.node_position)
    x = {1.05 * x[0] + 0.08 * x[2], x[1] + 0.002 * std::cos(70 * x[2]), 1.06 * x[2] + 0.002 * std::sin(40 * x[0])};
}

void stretch_and_compress_on_the_sphere(const Model& m, HostState& s) {
  for (Vec3& x : s.node_position) x[1] -= 0.0095;
  stretch_and_compress(m, s);
}

/// Without solids, so that a host factors the cloth's matrix, and solved until only rounding is left.
std::string free_of_solids() {
  const std::string scene = wet_scene().substr(0, wet_scene().find("bodies:"));
  const std::string tolerance = double_precision ? "1.0e-12" : "1.0e-6";
  return with(scene, "cloth:\n", "cloth_solver: {tolerance: " + tolerance + ", max_iterations: 20000}\ncloth:\n");
}

}  // namespace

TEST(cloth, agrees_with_the_reference) { compare_stage({.stage = Stage::cloth, .changes = "node_velocity"}); }

TEST(cloth, in_contact_with_a_sphere_agrees_with_the_reference) {
  compare_stage({.stage = Stage::cloth, .prepare = press_on_the_sphere, .changes = "node_contact_force"});
}

TEST(cloth, by_xpbd_agrees_with_the_reference) {
  compare_stage({.stage = Stage::cloth, .scene = xpbd_scene(), .changes = "node_velocity"});
}

TEST(cloth, by_xpbd_beyond_its_strain_limit_agrees_with_the_reference) {
  compare_stage({.stage = Stage::cloth,
                 .scene = limited(xpbd_scene()),
                 .prepare = stretch_and_compress,
                 .changes = "node_velocity"});
}

TEST(cloth, by_xpbd_within_a_cap_that_is_too_low_agrees_with_the_reference) {
  compare_stage({.stage = Stage::cloth,
                 .scene = with(limited(xpbd_scene()), "method: xpbd", "method: xpbd, max_iterations: 60"),
                 .prepare = stretch_and_compress,
                 .changes = "node_velocity"});
}

TEST(cloth, momentum_of_xpbd_yields_where_the_residual_does_not_fall_in_time) {
  using kokkos_backend::ClothProgress;
  const auto gap_after = [](int patience, std::initializer_list<double> residuals) {
    ClothProgress p;
    p.rho = 0.99;
    p.patience = patience;
    for (const double r : residuals) p.judge(r);
    return 1 - p.rho;
  };
  EXPECT_DOUBLE_EQ(gap_after(0, {5, 6, 7, 8}), gap_after(0, {5}));
  EXPECT_NEAR(gap_after(1, {5, 6, 5, 4}), 0.02, 1e-12) << "one check that does not fall";
  EXPECT_NEAR(gap_after(1, {5, 6, 7}), 0.04, 1e-12) << "two of them";
  EXPECT_NEAR(gap_after(3, {5, 6, 7, 4, 6, 6, 3}), 0.01, 1e-12) << "each third check falls";
  EXPECT_NEAR(gap_after(3, {5, 4, 4, 6}), 0.02, 1e-12) << "the third check does not";
  EXPECT_NEAR(gap_after(9, {5, 60}), 0.02, 1e-12) << "tenfold at once";

  ClothProgress moved;  // a target that was not reached leaves no patience, one that was does
  moved.rho = 0.99;
  moved.patience = 9;
  moved.judge(0.5);
  moved.move_on(false);
  EXPECT_EQ(moved.patience, 9);
  moved.judge(2);
  moved.move_on(false);
  EXPECT_EQ(moved.patience, 1);
  moved.judge(30);  // the new target's first
  EXPECT_DOUBLE_EQ(moved.rho, 0.99);
}

TEST(cloth, iterations_stall_where_their_residual_has_stopped_falling) {
  using kokkos_backend::ClothProgress;
  const auto checks_until_stall = [](const std::function<double(int)>& residual) {
    ClothProgress p;
    p.ends_at_stall = true;
    int checks = 0;
    for (; checks < 1000 && !p.stalls(); ++checks) p.judge(residual(checks));
    return checks;
  };
  const int limit = kokkos_backend::stall_checks;
  EXPECT_EQ(checks_until_stall([](int) { return 5.0; }), 1 + limit);
  EXPECT_EQ(checks_until_stall([](int k) { return k < 30 ? 1e3 * std::pow(0.8, k) : 50.0 + k % 3; }), 30 + limit);
  EXPECT_EQ(checks_until_stall([](int k) { return 1e6 * std::pow(0.99, k); }), 1000) << "slow, but to its goal";
  EXPECT_EQ(checks_until_stall([](int k) { return std::pow(0.99, k) * (k % 20 == 0 ? 10 : 100); }), 1000)
      << "swings, but falls";
  ClothProgress moved;
  for (int k = 0; k <= limit; ++k) moved.judge(5);
  EXPECT_FALSE(moved.stalls()) << "nothing follows";
  moved.ends_at_stall = true;
  ASSERT_TRUE(moved.stalls());
  moved.move_on(true);
  EXPECT_FALSE(moved.stalls());
}

// Where Newton's method follows, iterations that would take longer end early.
TEST(cloth, iterations_end_where_they_are_expected_to_take_longer_than_what_follows) {
  const auto checks_until_end = [](double worth, const std::function<double(int)>& residual) {
    kokkos_backend::ClothProgress p;
    p.ends_at_stall = true;
    p.worth = worth;
    int checks = 0;
    for (; checks < 300 && !p.stalls(); ++checks) p.judge(residual(checks));
    return checks;
  };
  // 1e3 falls to 1 within 69 checks, 690 iterations, at 10 % per check.
  const auto steady = [](int k) { return 1e3 * std::pow(0.9, k); };
  const int second = 2 * kokkos_backend::forecast_checks;
  EXPECT_EQ(checks_until_end(450, steady), second) << "465 more are needed";
  EXPECT_EQ(checks_until_end(480, steady), 300);
  EXPECT_EQ(checks_until_end(kokkos_backend::unlimited, steady), 300);
  // What falls only after a while is given the time until the second forecast.
  EXPECT_EQ(checks_until_end(480, [](int k) { return k < 12 ? 1e3 : 1e3 * std::pow(0.7, k - 12); }), 300);
  EXPECT_EQ(checks_until_end(1e4, [](int k) { return 1e3 * std::pow(1.01, k % 10); }), second) << "no fall at all";
}

TEST(cloth, by_xpbd_in_contact_with_a_sphere_agrees_with_the_reference) {
  compare_stage(
      {.stage = Stage::cloth, .scene = xpbd_scene(), .prepare = press_on_the_sphere, .changes = "node_contact_force"});
}

TEST(cloth, stretched_and_compressed_beyond_its_strain_limit_agrees_with_the_reference) {
  compare_stage({.stage = Stage::cloth,
                 .scene = limited(wet_scene()),
                 .prepare = stretch_and_compress_on_the_sphere,
                 .changes = "node_velocity"});
}

TEST(cloth, woven_agrees_with_the_reference) {
  const std::string damped = with(woven(wet_scene()), "    pin:", "    strain_damping: 0.003\n    pin:");
  for (const std::string& scene : {woven(wet_scene()), damped, limited(damped)}) {
    compare_stage({.stage = Stage::cloth, .scene = scene, .changes = "node_velocity"});
    compare_stage(
        {.stage = Stage::cloth, .scene = scene, .prepare = press_on_the_sphere, .changes = "node_contact_force"});
  }
  compare_stage({.stage = Stage::cloth,
                 .scene = limited(damped),
                 .prepare = stretch_and_compress_on_the_sphere,
                 .changes = "node_velocity"});
  compare_stage({.stage = Stage::pressure,
                 .scene = woven(wet_scene()),
                 .steps_before =
                     16,  // after 12 the liquid does not press yet; later the cloth's lots end at other counts in float
                 .changes = "node_velocity"});
}

/// Yarns that lock, below and beyond the strains up to which they follow their law in the step.
TEST(cloth, woven_of_yarns_that_lock_agrees_with_the_reference) {
  using Prepare = std::function<void(const Model&, HostState&)>;
  const auto locking = [](const std::string& scene, double warp, double weft) {
    return with(scene, "wet: 0.5}", fmt::format("wet: 0.5, warp_locking: {}, weft_locking: {}}}", warp, weft));
  };
  const auto thrown_apart = [](const Model& m, HostState& s) {
    stretch_and_shear(m, s);
    for (std::size_t n = 0; n < s.node_velocity.size(); ++n)
      s.node_velocity[n] = {30 * s.node_position[n][0], 0, 25 * s.node_position[n][2]};
  };
  const std::string on_sphere = locking(woven(wet_scene()), 0.3, 0.2);
  compare_stage({.stage = Stage::cloth, .scene = on_sphere, .changes = "node_velocity"});
  for (const std::string& scene : {on_sphere, limited(on_sphere)})
    compare_stage(
        {.stage = Stage::cloth, .scene = scene, .prepare = press_on_the_sphere, .changes = "node_contact_force"});
  const std::string free = locking(woven(free_of_solids(), false), 0.1, 0.05);
  for (const std::string& scene : {free, with(free, "cloth_solver: {", "cloth_solver: {method: xpbd, ")})
    for (const Prepare& prepare : {Prepare(stretch_and_shear), Prepare(thrown_apart)})
      compare_stage({.stage = Stage::cloth, .scene = scene, .prepare = prepare, .changes = "node_velocity"});
}

TEST(cloth, that_expands_when_it_is_wet_agrees_with_the_reference) {
  const auto expanding = [](const std::string& scene) {
    return with(scene, "porous: {", "porous: {hygral_expansion: 0.08, ");
  };
  for (const std::string& scene : {expanding(wet_scene()), expanding(limited(woven(wet_scene()))),
                                   expanding(xpbd_scene()), expanding(woven(xpbd_scene(), false))})
    compare_stage({.stage = Stage::cloth, .scene = scene, .changes = "node_velocity"});
}

TEST(cloth, woven_by_xpbd_agrees_with_the_reference) {
  const std::string scene = woven(xpbd_scene(), false);
  compare_stage({.stage = Stage::cloth, .scene = scene, .changes = "node_velocity"});
  compare_stage({.stage = Stage::cloth, .scene = scene, .prepare = stretch_and_shear, .changes = "node_velocity"});
}

/// A host factors the Hessian: of a sheet that is slack, and of one that is stretched and sheared.
TEST(cloth, woven_and_free_of_solids_agrees_with_the_reference) {
  const std::string plain = woven(free_of_solids()),
                    damped = with(plain, "    pin:", "    strain_damping: 0.003\n    pin:");
  for (const std::string& scene :
       {plain, damped, with(plain, "thickness: 0.002", "thickness: 0.002\n    strain_limit: 0.2")}) {
    compare_stage({.stage = Stage::cloth, .scene = scene, .changes = "node_velocity"});
    compare_stage({.stage = Stage::cloth, .scene = scene, .prepare = stretch_and_shear, .changes = "node_velocity"});
  }
}

TEST(cloth, free_of_solids_agrees_with_the_reference) {
  const std::string plain = free_of_solids(), pin = "    pin: [{edges: true}]", thin = "thickness: 0.002";
  const std::string moving =
      "{edges: true, velocity: [0.1, 0.3, -0.2], start: 0.003, end: 0.0251, "
      "spin: {axis: [1, 2, 0], degrees_per_second: 200, center: [0.1, 0, 0]}}";
  for (const std::string& scene : {plain, with(plain, pin, "    strain_damping: 0.003\n" + pin),
                                   with(plain, thin, thin + "\n    strain_limit: 0.2"),
                                   with(plain, thin, thin + "\n    bend: 0.01\n    stretch: 50")})
    compare_stage({.stage = Stage::cloth, .scene = scene, .changes = "node_velocity"});
  if (!computes_on_host()) return;                           // a GPU's iterations are those of the tests above
  for (const Stage stage : {Stage::cloth, Stage::pressure})  // pins that rise into the liquid
    compare_stage({.stage = stage,
                   .scene = with(plain, "{edges: true}", moving),
                   .steps_before = 30,
                   .changes = "node_velocity"});
}

TEST(cloth, wet_in_contact_agrees_with_the_reference) {
  compare_stage(
      {.stage = Stage::cloth,
       .scene = with(wet_scene(), "thickness: 0.002", "thickness: 0.002\n    friction_wet: 1.2\n    damping_wet: 30"),
       .prepare = press_on_the_sphere,
       .changes = "node_contact_force"});
}

/// The steps of so few iterations on so stiff a sheet go uphill, and the line search shortens them.
TEST(cloth, ended_at_its_cap_agrees_with_the_reference) {
  const std::string scene =
      with(wet_scene(), "thickness: 0.002", "thickness: 0.002\n    areal_density: 0.05\n    stretch: 2.0e4");
  for (const std::string method : {"pd", "xpbd"})
    compare_stage(
        {.stage = Stage::cloth,
         .scene = with(scene, "cloth:\n",
                       "cloth_solver: {tolerance: 1.0e-6, max_iterations: 12, method: " + method + "}\ncloth:\n"),
         .prepare = press_on_the_sphere,
         .changes = "node_velocity"});
}

/// The edges turn and rise, and stop at a time within the step under test.
TEST(cloth, held_by_moving_pins_agrees_with_the_reference) {
  const std::string scene = with(wet_scene(), "{edges: true}",
                                 "{edges: true, velocity: [0.1, 0.3, -0.2], start: 0.003, end: 0.0251, "
                                 "spin: {axis: [1, 2, 0], degrees_per_second: 200, center: [0.1, 0, 0]}}");
  for (const Stage stage : {Stage::cloth, Stage::pressure, Stage::advection})
    compare_stage(
        {.stage = stage, .scene = scene, .changes = stage == Stage::advection ? "node_position" : "node_velocity"});
}

/// Keys of all that moves pins, one of them within the step under test.
TEST(cloth, held_by_pins_with_keys_agrees_with_the_reference) {
  for (const std::string between : {"linear", "smooth"}) {
    const std::string scene =
        with(wet_scene(), "{edges: true}",
             "{edges: true, velocity: {keys: [[0, [0, 0, 0]], [0.0235, [0.3, 0.4, -0.2]], [0.04, [0, 0, 0]]], "
             "interpolation: " +
                 between +
                 "}, offset: {keys: [[0, [0, 0, 0]], [0.0235, [0, 0.002, 0.003]], [0.05, [0, 0, 0]]], interpolation: " +
                 between +
                 "}, end: 0.0251, spin: {axis: [1, 2, 0], center: [0.1, 0, 0], "
                 "degrees_per_second: {keys: [[0, 0], [0.03, 400]], interpolation: " +
                 between + "}}}");
    for (const Stage stage : {Stage::cloth, Stage::pressure, Stage::advection})
      compare_stage(
          {.stage = stage, .scene = scene, .changes = stage == Stage::advection ? "node_position" : "node_velocity"});
  }
}

/// Pins that turned and rose, and were then told to go another way.
TEST(cloth, held_by_pins_that_a_program_moves_agrees_with_the_reference) {
  const std::string scene = with(wet_scene(), "{edges: true}",
                                 "{edges: true, velocity: [0.1, 0.3, -0.2], spin: {axis: [1, 2, 0], "
                                 "degrees_per_second: 200, center: [0.1, 0, 0]}}");
  for (const Stage stage : {Stage::cloth, Stage::pressure, Stage::advection})
    compare_stage({.stage = stage,
                   .scene = scene,
                   .resolve =
                       [](Model& model) {
                         change_pin_velocity(model, 0, 0, {-0.2, 0.1, 0.3}, 0.004);
                       },
                   .changes = stage == Stage::advection ? "node_position" : "node_velocity"});
}

/// Soft pins that pull at a wet sheet, and at one that a solid carries.
TEST(cloth, held_by_soft_pins_agrees_with_the_reference) {
  const std::string soft = "{edges: true, stiffness: 300, velocity: [0.1, 0.3, -0.2], start: 0.003}";
  const std::string scene = with(wet_scene(), "{edges: true}", soft);
  for (const std::string& one : {scene, with(xpbd_scene(), "{edges: true}", soft)})
    for (const char* changed : {"node_velocity", "node_pin_force"})
      compare_stage({.stage = Stage::cloth, .scene = one, .changes = changed});
  for (const Stage stage : {Stage::pressure, Stage::advection})
    compare_stage(
        {.stage = stage, .scene = scene, .changes = stage == Stage::advection ? "node_position" : "node_pin_force"});
  compare_stage({.stage = Stage::cloth, .scene = scene, .prepare = press_on_the_sphere, .changes = "node_pin_force"});
  for (const Stage stage : {Stage::cloth, Stage::pressure})
    compare_stage({.stage = stage,
                   .scene = with(wet_scene(), "{edges: true}", "{edges: true, stiffness: 300, release: 0}"),
                   .changes = "node_velocity"});
}

/// Pins that move and turn with a body beside the scene.
TEST(cloth, held_by_pins_that_follow_a_body_agrees_with_the_reference) {
  const std::string scene = with(with(wet_scene(), "bodies:\n",
                                      "bodies:\n  - name: handle\n    sphere: {center: [0.12, -0.12, 0.12], radius: "
                                      "0.001, velocity: [0.1, 0.3, -0.2], "
                                      "spin: {axis: [1, 2, 0], degrees_per_second: 200}}\n"),
                                 "{edges: true}", "{edges: true, body: handle}");
  for (const Stage stage : {Stage::cloth, Stage::pressure, Stage::advection})
    compare_stage(
        {.stage = stage, .scene = scene, .changes = stage == Stage::advection ? "node_position" : "node_velocity"});
}

}  // namespace drench::test
