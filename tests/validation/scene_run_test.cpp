// Whole runs of the project's own scenes: the ledger, the bounds of saturation, the wet cloth's sag, and the same bits every time.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "pipeline/pipeline.hpp"
#include "scene/build.hpp"
#include "scene/load.hpp"

namespace drench::test {
namespace {

std::string scene_path(const std::string& name) { return std::string(DRENCH_SCENES_DIR) + "/" + name; }

double lowest(const HostState& s) {
  double y = 1e9;
  for (const Vec3& x : s.node_position) y = std::min(y, x[1]);
  return y;
}

}  // namespace

TEST(water_on_cloth, conserves_every_quantum_soaks_and_sags_over_the_whole_run) {
  const drench::Setup setup = build(load_scene(scene_path("water_on_cloth.yaml")));
  const auto backend = make_kokkos_backend(setup.model);
  Pipeline pipeline(setup.model, *backend, setup.state);
  std::int64_t steps = 0, compressed = 0;
  double soaked_half = 0, soaked = 0, worst_float = 0;
  double dry_low = 0;
  while (pipeline.time() < setup.model.scene.time.end - 1e-9) {
    const StepReport r = pipeline.step(setup.model.scene.time.end - pipeline.time());
    ASSERT_EQ(r.mass_total(), pipeline.initial_total());
    ASSERT_LE(r.saturation_max, 1.18);
    ASSERT_GE(r.mass_cloth, 0);
    ++steps;
    if (r.density_error > 1e-3) ++compressed;
    const double account = static_cast<double>(r.mass_fluid + r.mass_cloth) * setup.model.quantum;
    worst_float = std::max(worst_float, std::fabs(r.mass_float - account) / account);
    soaked = static_cast<double>(r.mass_cloth) * setup.model.quantum;
    if (pipeline.time() < 0.5 * setup.model.scene.time.end) soaked_half = soaked;
    if (pipeline.time() < 0.04) dry_low = lowest(backend->download());
  }
  EXPECT_LE(worst_float, 1e-6);
  EXPECT_LE(static_cast<double>(compressed), 0.05 * static_cast<double>(steps));
  EXPECT_GT(soaked, 0.05);                              // kg
  EXPECT_LT(std::fabs(soaked - soaked_half), 0.3 * soaked);  // levels off
  const HostState end = backend->download();
  EXPECT_LT(lowest(end), dry_low - 0.005);  // m
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

TEST(cloth_only, hangs_still_and_its_pins_carry_its_weight) {
  const drench::Setup setup = build(load_scene(scene_path("cloth_only.yaml"), {"cloth.0.damping=8", "time.end=6"}));
  const auto backend = make_kokkos_backend(setup.model);
  Pipeline pipeline(setup.model, *backend, setup.state);
  for (int s = 0; s < 1500; ++s) pipeline.step(1.0);
  const HostState end = backend->download();
  double pins = 0, speed = 0, gap = 1e9;
  for (const Vec3& f : end.node_pin_force) pins += f[1];
  for (const Vec3& v : end.node_velocity) speed = std::max(speed, std::hypot(v[0], v[1], v[2]));
  for (const Vec3& x : end.node_position) gap = std::min(gap, std::hypot(x[0], x[1] + 0.35, x[2]) - 0.2);
  EXPECT_LT(speed, 0.02);           // m/s
  EXPECT_GE(gap, 0.001 - 1e-4);     // m: thickness
  EXPECT_LE(pins, 0.2 * 9.81 * 1.02);  // N: the sphere may carry the rest
  EXPECT_GT(pins, 0.2 * 9.81 * 0.3);
}

TEST(wick, front_follows_the_diffusion_law) {
  // One end held at s = 1 on a long strip: s(x, t) = erfc(x / (2 √(D t))).
  const drench::Setup setup = build(load_scene(scene_path("wick.yaml")));
  const auto backend = make_kokkos_backend(setup.model);
  Pipeline pipeline(setup.model, *backend, setup.state);
  const double t_end = 2.0, diffusivity = 1.0e-3;
  while (pipeline.time() < t_end - 1e-9) {
    const StepReport r = pipeline.step(t_end - pipeline.time());
    ASSERT_EQ(r.mass_total(), pipeline.initial_total());
  }
  const HostState end = backend->download();
  double error = 0, sum = 0;
  for (std::size_t n = 0; n < end.node_position.size(); ++n) {
    const double x = end.node_position[n][0] + 0.18;  // distance from the held nodes' edge
    if (x < 0.001 || std::fabs(end.node_position[n][2]) > 0.02) continue;
    const double s = static_cast<double>(end.node_liquid[n]) * setup.model.quantum / setup.model.samples.node_capacity[n];
    const double exact = std::erfc(x / (2 * std::sqrt(diffusivity * t_end)));
    error += (s - exact) * (s - exact);
    sum += 1;
  }
  EXPECT_LT(std::sqrt(error / sum), 0.02);
}

}  // namespace drench::test
