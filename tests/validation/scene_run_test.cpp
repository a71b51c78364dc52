// Whole runs of the project's own scenes: the ledger, the bounds of saturation, the wet cloth's sag, and the same bits
// every time.

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "paths.hpp"
#include "pipeline/pipeline.hpp"
#include "scene/load.hpp"
#include "setup/build.hpp"
#include "validation.hpp"

namespace drench::test {
namespace {

std::string scene_path(const std::string& name) { return scenes_folder() + "/" + name; }

/// How often the solves end at max_iterations, and their mean and largest numbers of iterations.
struct Iterations {
  int steps = 0, capped = 0, most_density = 0, most_divergence = 0;
  double density = 0, divergence = 0;
  void count(const StepReport& r) {
    ++steps;
    capped += !r.density_converged || !r.divergence_converged;
    density += r.density_iterations;
    divergence += r.divergence_iterations;
    most_density = std::max(most_density, r.density_iterations);
    most_divergence = std::max(most_divergence, r.divergence_iterations);
  }
  void report_as(const std::string& scene) const {
    std::printf("%s: density %.1f iterations a step, at most %d; divergence %.1f, at most %d\n", scene.c_str(),
                density / steps, most_density, divergence / steps, most_divergence);
    report({scene + ": steps that end at max_iterations", "1 %", double(capped) / steps, 0.01});
  }
};

double lowest(const HostState& s) {
  double y = 1e9;
  for (const Vec3& x : s.node_position) y = std::min(y, x[1]);
  return y;
}

/// Lowest node (m) of the scene's cloth without its liquid, once it hangs still.
double settled_dry_low(Scene scene) {
  scene.fluid = {};
  const drench::Setup setup = build(scene);
  const auto backend = make_kokkos_backend(setup.model);
  Pipeline pipeline(setup.model, *backend, setup.state);
  double low = 0, fall = 1;
  for (int s = 0; s < 50; ++s) pipeline.step(1.0);  // it falls from rest
  for (int k = 0; k < 40 && fall > 1e-5; ++k) {
    for (int s = 0; s < 25; ++s) pipeline.step(1.0);
    const double before = low;
    low = lowest(backend->download());
    fall = std::fabs(low - before);
  }
  EXPECT_LE(fall, 1e-5) << "m in 0.1 s: the dry cloth does not settle";
  return low;
}

}  // namespace

TEST(water_on_cloth, conserves_every_quantum_soaks_and_sags_over_the_whole_run) {
  if (double_precision) GTEST_SKIP() << "a minute and a half; run in float";
  const drench::Setup setup = build(load_scene(scene_path("water_on_cloth.yaml")));
  const double dry_low = settled_dry_low(setup.model.scene);
  const auto backend = make_kokkos_backend(setup.model);
  Pipeline pipeline(setup.model, *backend, setup.state);
  std::int64_t steps = 0, compressed = 0;
  Iterations iterations;
  double soaked_half = 0, soaked = 0, worst_float = 0;
  while (pipeline.time() < setup.model.scene.time.end - 1e-9) {
    const StepReport r = pipeline.step(setup.model.scene.time.end - pipeline.time());
    ASSERT_EQ(r.mass_total(), pipeline.initial_total());
    ASSERT_LE(r.saturation_max, 1.18);
    ASSERT_GE(r.mass_cloth, 0);
    ++steps;
    if (r.density_error > 1e-3) ++compressed;
    iterations.count(r);
    const double account = static_cast<double>(r.mass_fluid + r.mass_cloth) * setup.model.quantum;
    worst_float = std::max(worst_float, std::fabs(r.mass_float - account) / account);
    soaked = static_cast<double>(r.mass_cloth) * setup.model.quantum;
    if (pipeline.time() < 0.5 * setup.model.scene.time.end) soaked_half = soaked;
  }
  iterations.report_as("scenes/water_on_cloth.yaml, whole run");
  EXPECT_LE(worst_float, 1e-6);
  EXPECT_LE(static_cast<double>(compressed), 0.05 * static_cast<double>(steps));
  EXPECT_GT(soaked, 0.05);                                   // kg
  EXPECT_LT(std::fabs(soaked - soaked_half), 0.3 * soaked);  // levels off
  const HostState end = backend->download();
  EXPECT_LT(lowest(end), dry_low - 0.02);  // m
  for (Quanta m : end.node_liquid) ASSERT_GE(m, 0);
}

TEST(water_on_cloth, two_runs_give_the_same_bits) {
  const drench::Setup setup = build(load_scene(scene_path("water_on_cloth.yaml")));
  HostState results[2];
  for (HostState& result : results) {
    const auto backend = make_kokkos_backend(setup.model);
    Pipeline pipeline(setup.model, *backend, setup.state);
    for (int s = 0; s < 50; ++s) pipeline.step(1.0);
    result = backend->download();
  }
  EXPECT_EQ(results[0].fluid_position, results[1].fluid_position);
  EXPECT_EQ(results[0].fluid_velocity, results[1].fluid_velocity);
  EXPECT_EQ(results[0].fluid_mass, results[1].fluid_mass);
  EXPECT_EQ(results[0].node_position, results[1].node_position);
  EXPECT_EQ(results[0].node_liquid, results[1].node_liquid);
}

TEST(dam_break, starts_at_rest_and_converges_in_every_step) {
  const drench::Setup setup = build(load_scene(scene_path("dam_break.yaml")));
  const auto backend = make_kokkos_backend(setup.model);
  Pipeline pipeline(setup.model, *backend, setup.state);
  StepReport r = pipeline.step(1.0);
  Iterations iterations;
  // A lattice that touches walls is not compressed: after one step it moves with what gravity has given it.
  const double mass = static_cast<double>(r.mass_fluid) * setup.model.quantum;
  const double fall = 9.81 * r.dt;
  EXPECT_LE(r.kinetic_energy, 0.5 * mass * fall * fall);
  while (pipeline.time() < 0.5) {
    r = pipeline.step(1.0);
    EXPECT_TRUE(r.density_converged) << "step " << pipeline.step_index();
    EXPECT_TRUE(r.divergence_converged) << "step " << pipeline.step_index();
    iterations.count(r);
  }
  iterations.report_as("scenes/dam_break.yaml, 0.5 s");
}

TEST(cloth_only, comes_to_rest_on_the_sphere_at_its_thickness) {
  const drench::Setup setup = build(load_scene(scene_path("cloth_only.yaml"), {"cloth.0.damping=8"}));
  const auto backend = make_kokkos_backend(setup.model);
  Pipeline pipeline(setup.model, *backend, setup.state);
  for (int s = 0; s < 750; ++s) pipeline.step(1.0);
  const HostState end = backend->download();
  double speed = 0, gap = 1e9;
  for (const Vec3& v : end.node_velocity) speed = std::max(speed, std::hypot(v[0], v[1], v[2]));
  for (const Vec3& x : end.node_position) gap = std::min(gap, std::hypot(x[0], x[1] + 0.35, x[2]) - 0.2);
  EXPECT_LT(speed, 0.05);        // m/s
  EXPECT_GE(gap, 0.001 - 1e-4);  // m: thickness
}

TEST(wick, uptake_follows_the_square_root_of_time) {
  // One end held at s = 1 on a long strip of width b: m(t) = (1 − Φ) τ ρ b · 2 √(D t / π) (Crank 1975). The difference
  // between two times does not depend on where within a cell the reservoir ends.
  const drench::Setup setup = build(load_scene(scene_path("wick.yaml")));
  const auto backend = make_kokkos_backend(setup.model);
  Pipeline pipeline(setup.model, *backend, setup.state);
  const double diffusivity = 1.0e-3, pi = 3.14159265358979323846;
  double taken[2];
  for (int k = 0; k < 2; ++k) {
    const double until = k == 0 ? 0.5 : 2.0;
    StepReport r;
    while (pipeline.time() < until - 1e-9) {
      r = pipeline.step(until - pipeline.time());
      ASSERT_EQ(r.mass_total(), pipeline.initial_total());
    }
    taken[k] = static_cast<double>(r.mass_cloth) * setup.model.quantum;
  }
  const double exact = 0.6 * 0.001 * 1000 * 0.1 * 2 * std::sqrt(diffusivity / pi) * (std::sqrt(2.0) - std::sqrt(0.5));
  EXPECT_NEAR((taken[1] - taken[0]) / exact, 1, 0.05);
}

}  // namespace drench::test
