// Stage pressure: backend against reference from identical input.

#include "stages/pressure.hpp"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "base/eigen_vec.hpp"
#include "pipeline/pipeline.hpp"
#include "precision.hpp"
#include "stage_compare.hpp"
#include "stages/pressure.hpp"
#include "states.hpp"

namespace drench::test {
namespace {

/// The pressure solve of a step of 1 ms from a state, which has to converge.
StepReport press(Backend& backend, const HostState& state) {
  backend.upload(state);
  StepReport report;
  for (const Stage stage : {Stage::neighbors, Stage::density, Stage::pressure})
    backend.run(stage, {0, 0, 0.001}, report);
  EXPECT_TRUE(report.density_converged);
  return report;
}

const std::string box_scene = std::string(few_iterations) + R"(
    - block: {min: [0, 0, 0], max: [0.2, 0.24, 0.16]}
bodies: [{box: {min: [0, 0, 0], max: [0.24, 0.4, 0.16], inside: true}}]
)";

HostState after_steps(const drench::Setup& setup) {
  const auto reference = make_reference_backend(setup.model);
  Pipeline pipeline(setup.model, *reference, setup.state);
  for (int s = 0; s < 12; ++s) pipeline.step(1.0);
  return reference->download();
}

}  // namespace

TEST(pressure, agrees_with_the_reference) {
  compare_stage_with_every_kernel({.stage = Stage::pressure, .steps_before = 40, .changes = "fluid_velocity"});
}

TEST(pressure, of_crowded_and_light_particles_agrees_with_the_reference) {
  // After 41 steps: after 40, with `cubic`, the cloth's residual is so near its goal at a check that single and double
  // precision stop ten iterations apart.
  compare_stage_with_every_kernel(
      {.stage = Stage::pressure, .steps_before = 41, .prepare = crowd, .changes = "fluid_velocity"});
}

TEST(pressure, of_squeezed_liquid_agrees_with_the_reference) {
  // At 1.6 to 4.6 times water's density, on both sides of the bound from which the relaxation falls.
  for (const double size : {0.85, 0.6})
    compare_stage({.stage = Stage::pressure,
                   .scene = box_scene,
                   .steps_before = 2,
                   .prepare =
                       [size](const Model&, HostState& s) {
                         for (Vec3& x : s.fluid_position)
                           for (double& c : x) c = float(0.08 + size * (c - 0.08));
                       },
                   .changes = "fluid_velocity"});
}

TEST(pressure, of_particles_that_touch_the_sheet_agrees_with_the_reference) {
  // Every fourth that has the sheet within h comes to 0.02 to 0.18 d from it, the lists' side kept; some touch, some do
  // not.
  const auto lower = [](const Model& m, HostState& s) {
    int touching = 0, thin = 0;
    for (std::size_t i = 0; i < s.fluid_position.size(); i += 4) {
      const NearestSample sample = nearest_sample(m, s, s.fluid_position[i], m.support);
      if (!sample.found) continue;
      const Eigen::Vector3d x = to_eigen(s.fluid_position[i]), normal = to_eigen(sample.normal);
      const double height = (x - to_eigen(sample.position)).dot(normal), share = 0.02 + 0.16 * double(i % 16) / 12;
      s.fluid_position[i] = to_vec3(x + ((height < 0 ? -share : share) * m.spacing - height) * normal);
      touching += share < 0.1 ? 1 : 0;
      thin += s.fluid_density_ratio[i] < 1 ? 1 : 0;
    }
    EXPECT_GT(touching, 5);
    EXPECT_GT(thin, 5) << "there δ counts as 1";
  };
  compare_stage({.stage = Stage::pressure, .steps_before = 40, .prepare = lower, .changes = "fluid_velocity"});
}

TEST(pressure, lets_no_particle_approach_the_sheet_that_it_touches) {
  // A slab of three layers on a fixed sheet, of which the upper two fly off while the lowest is thrown at the sheet:
  // the liquid as a whole thins out, so nothing but the contact holds the lowest layer.
  const drench::Setup setup = setup_from(R"(drench: 1
gravity: [0, 0, 0]
domain: {min: [-1, -1, -1], max: [1, 1, 1]}
fluid:
  spacing: 0.01
  solver: {density_error: 1.0e-6, max_iterations: 1000}
  sources: [{block: {min: [-0.035, 0.05, -0.035], max: [0.035, 0.08, 0.035]}}]
cloth:
  - mesh: {grid: {size: [0.2, 0.2], nodes: [11, 11]}}
    dynamics: false
)");
  HostState s = setup.state;
  ASSERT_EQ(s.fluid_count(), 147);
  for (std::size_t i = 0; i < s.fluid_position.size(); ++i) {
    s.fluid_position[i][1] -= 0.0545;  // 5e-4 m above the sheet: touching
    const bool lowest = s.fluid_position[i][1] < 0.005;
    s.fluid_velocity[i] = {0, lowest ? -1.0 : 400 * s.fluid_position[i][1], 0};
  }
  for (const auto& backend : {make_reference_backend(setup.model), make_kokkos_backend(setup.model)}) {
    SCOPED_TRACE(backend->name());
    press(*backend, s);
    const HostState end = backend->download();
    int lowest = 0;
    for (std::size_t i = 0; i < end.fluid_position.size(); ++i) {
      const double x = end.fluid_position[i][1], v = end.fluid_velocity[i][1];
      if (x < 0.005) {
        ++lowest;
        EXPECT_NEAR(v, 0, 0.01) << "particle " << i;
      } else {
        EXPECT_NEAR(v, 400 * x, 1e-3) << "particle " << i << " does not touch";
      }
    }
    EXPECT_EQ(lowest, 49);
  }
}

TEST(pressure, takes_back_the_share_of_a_compression_that_the_scene_asks_for) {
  // A cube of liquid in free space, smaller than it should be.
  for (const double squeezed : {0.01, 0.05, 0.09}) {
    double most = 0;  // compression that the step finds
    for (const double c : {0.5, 0.75, 1.0}) {
      SCOPED_TRACE(fmt::format("{} of a cube whose edges are {} too short", c, squeezed));
      const drench::Setup setup = setup_from(fmt::format(R"(drench: 1
gravity: [0, 0, 0]
domain: {{min: [-1, -1, -1], max: [1, 1, 1]}}
fluid:
  spacing: 0.01
  solver: {{density_error: 1.0e-6, max_iterations: 1000, density_correction: {}}}
  sources: [{{block: {{min: [-0.06, -0.06, -0.06], max: [0.06, 0.06, 0.06]}}}}]
)",
                                                         c));
      HostState s = setup.state;
      for (Vec3& x : s.fluid_position) x = to_vec3((1 - squeezed) * to_eigen(x));
      for (const auto& backend : {make_reference_backend(setup.model), make_kokkos_backend(setup.model)}) {
        SCOPED_TRACE(backend->name());
        const StepReport report = press(*backend, s);
        // As the law has it: c of a compression up to 0.1, but half at least.
        double left = 0;
        const HostState found = backend->download();
        for (const double ratio : found.fluid_density_ratio) {
          const double over = std::max(0.0, ratio - 1);
          most = std::max(most, over);
          left += over - std::max(over / 2, std::min(c * over, 0.1));
        }
        left /= double(found.fluid_count());
        if (c == 1 && squeezed == 0.01) {
          EXPECT_EQ(left, 0) << "all is corrected";
        }
        EXPECT_GT(report.density_error, 0.95 * left - 1e-9) << "where liquid pushes out, its neighbours may lose more";
        EXPECT_LT(report.density_error, left + 1e-5);
      }
    }
    EXPECT_GT(most, squeezed == 0.09 ? 0.2 : squeezed == 0.05 ? 0.1 : 0);
  }
}

TEST(pressure, that_takes_back_all_of_a_compression_agrees_with_the_reference) {
  compare_stage({.stage = Stage::pressure,
                 .scene = with(wet_scene(), "min_iterations: 6", "min_iterations: 6, density_correction: 1"),
                 .steps_before = 41,
                 .prepare = crowd,
                 .changes = "fluid_velocity"});
}

// Liquid alone starts at a scaled κ: in a box with a wall that moves, with crowds, and as a divergence.
TEST(pressure, that_starts_scaled_agrees_with_the_reference) {
  const std::string scene = with(with(box_scene, "inside: true", "inside: true, velocity: [0.3, 0, 0]"), "fluid:\n",
                                 "fluid:\n  wall_pressure: mirrored\n");  // wall_pressure_test has the other
  for (const Stage stage : {Stage::pressure, Stage::divergence}) {
    compare_stage({.stage = stage, .scene = scene, .last_start = 3, .changes = "fluid_velocity"});
    compare_stage({.stage = stage, .scene = scene, .prepare = crowd, .last_start = 3, .changes = "fluid_velocity"});
  }
}

// The scale fits, so the size of what a solve starts with does not count.
TEST(pressure, does_not_depend_on_the_size_of_its_start) {
  const drench::Setup setup = setup_from(box_scene);
  const HostState before = after_steps(setup);
  StepInfo info{0, 0, 0.002};
  info.divergence_start = info.density_start = 3;
  for (const auto& backend : {make_reference_backend(setup.model), make_kokkos_backend(setup.model)}) {
    SCOPED_TRACE(backend->name());
    const auto velocities = [&](double size) {
      HostState s = before;
      for (double& kappa : s.fluid_kappa_density) kappa *= size;
      for (double& kappa : s.fluid_kappa_divergence) kappa *= size;
      backend->upload(s);
      StepReport report;
      for (const Stage stage : {Stage::neighbors, Stage::density, Stage::divergence, Stage::pressure})
        backend->run(stage, info, report);
      EXPECT_EQ(report.density_iterations, 6);
      return backend->download().fluid_velocity;
    };
    const std::vector<Vec3> as_it_was = velocities(1);
    const double rounding = double_precision || backend->name() == std::string("reference") ? 1e-11 : 2e-5;  // m/s
    for (const double size : {0.8, 2.0, 3.0}) {
      const std::vector<Vec3> scaled = velocities(size);
      double most = 0;
      for (std::size_t i = 0; i < scaled.size(); ++i)
        most = std::max(most, (to_eigen(scaled[i]) - to_eigen(as_it_was[i])).norm());
      EXPECT_LT(most, rounding) << "a start " << size << " times as high";
    }
  }
}

// A first iteration without any pressure finds what the step itself brings.
TEST(pressure, goes_on_until_a_part_of_the_steps_own_compression_is_left) {
  const auto solved = [](const std::string& limits) {
    const drench::Setup setup = setup_from(with(box_scene, "max_iterations: 6, min_iterations: 6", limits));
    HostState s = setup.state;
    for (Vec3& v : s.fluid_velocity) v = {0, -0.05, 0};
    std::vector<StepReport> reports;
    run_on_both(setup.model, s, {Stage::neighbors, Stage::density, Stage::pressure}, {0, 0, 0.002},
                [&](Backend&, const StepReport& report) { reports.push_back(report); });
    EXPECT_EQ(reports[0].density_iterations, reports[1].density_iterations) << limits;
    EXPECT_TRUE(reports[0].density_converged && reports[1].density_converged) << limits;
    EXPECT_NEAR(reports[1].density_error, reports[0].density_error, 1e-4 * reports[0].density_error + 1e-7);
    return reports[1];
  };
  const StepReport free = solved("density_error: 0.01, min_iterations: 1");
  EXPECT_EQ(free.density_iterations, 1);
  EXPECT_GT(free.density_error, 1e-4);
  int before = 1;
  for (const std::string part : {"0.2", "0.02"}) {
    const StepReport report = solved("density_error: 0.01, min_iterations: 1, source_error: " + part);
    EXPECT_LE(report.density_error, 1.02 * std::stod(part) * free.density_error);
    EXPECT_GT(report.density_iterations, before);
    before = report.density_iterations;
  }
  // A tolerance that is less than that part counts alone.
  const int alone = solved("density_error: 1.0e-5, min_iterations: 1").density_iterations;
  EXPECT_EQ(solved("density_error: 1.0e-5, min_iterations: 1, source_error: 0.5").density_iterations, alone);
}

TEST(pressure, that_ends_by_the_steps_own_compression_agrees_with_the_reference) {
  compare_stage({.stage = Stage::pressure,
                 .scene = with(wet_scene(), "max_iterations: 6, min_iterations: 6",
                               "density_error: 0.01, min_iterations: 1, source_error: 0.2"),
                 .steps_before = 40,
                 .changes = "fluid_velocity"});
}

TEST(pressure, with_cloth_by_xpbd_agrees_with_the_reference) {
  compare_stage({.stage = Stage::pressure,
                 .scene = with(wet_scene(), "cloth:\n", "cloth_solver: {method: xpbd}\ncloth:\n"),
                 .steps_before = 40,
                 .changes = "fluid_velocity"});
}

TEST(coupled_solve, ends_when_the_residual_of_the_cloth_no_longer_falls) {
  CoupledProgress falls, stays, rises;
  double residual = 1000;
  for (int k = 0; k < 60; ++k, residual *= 0.97) EXPECT_FALSE(falls.stalls(residual)) << k;
  for (int k = 0; k < 5; ++k) EXPECT_FALSE(stays.stalls(1000 - k)) << k;
  EXPECT_TRUE(stays.stalls(995));
  for (int k = 0; k < 5; ++k) EXPECT_FALSE(rises.stalls(10 + k)) << k;
  EXPECT_TRUE(rises.stalls(std::nan(""))) << "not a number";
}

}  // namespace drench::test
