// Stitches: what stages that know them compute, backend against reference; and a seam that closes.

#include <fmt/format.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <numbers>

#include "pipeline/backend.hpp"
#include "pipeline/pipeline.hpp"
#include "scene/load.hpp"
#include "stage_compare.hpp"
#include "states.hpp"

namespace drench::test {
namespace {

/// Stitches across the sheet that are half closed when the stage under test runs, and one that is closed from the
/// start.
std::string sewn(const std::string& scene) {
  return with(scene, "    pin:", "    sew: [{pairs: [[20, 24], [29, 33], [47, 51]]}]\n    sew_time: 0.05\n    pin:");
}

/// A sheet whose far edges are sewn to each other. It falls freely along its other sides, so that a solve always has a
/// scale.
const char* const strips = R"(drench: 1
time: {step: 0.004, end: 1}
gravity: [0, 0, -0.5]
domain: {min: [-1, -1, -1], max: [1, 1, 1]}
cloth:
  - name: sheet
    mesh: {grid: {size: [0.4, 0.2], nodes: [9, 5]}}
    self_collision: true
    thickness: 0.004
    sew: [{pairs: [[0, 8], [9, 17], [18, 26], [27, 35], [36, 44]]}]
    sew_time: 0.2
)";

double widest_stitch(const Model& m, const HostState& s) {
  double widest = 0;
  for (const auto& [a, b] : m.mesh.stitch) {
    const Vec3 &x = s.node_position[static_cast<std::size_t>(a)], &y = s.node_position[static_cast<std::size_t>(b)];
    widest = std::max(widest, std::hypot(x[0] - y[0], x[1] - y[1], x[2] - y[2]));
  }
  return widest;
}

}  // namespace

TEST(sewing, stage_cloth_agrees_with_the_reference) {
  compare_stage({.stage = Stage::cloth, .scene = sewn(wet_scene()), .changes = "node_velocity"});
}

TEST(sewing, stage_cloth_by_xpbd_agrees_with_the_reference) {
  compare_stage({.stage = Stage::cloth,
                 .scene = with(sewn(wet_scene()), "cloth:\n", "cloth_solver: {method: xpbd}\ncloth:\n"),
                 .changes = "node_velocity"});
}

TEST(sewing, stage_diffusion_agrees_with_the_reference) {
  compare_stage({.stage = Stage::diffusion, .scene = sewn(wet_scene()), .changes = "node_liquid"});
}

TEST(sewing, stage_self_collision_agrees_with_the_reference) {
  // A tube, nearly closed and pressed flat, so that its halves are nearer than they may be. The noise leaves no two
  // edges parallel: of those, rounding would decide which points are the nearest.
  const auto flatten = [](const Model& m, HostState& s) {
    for (std::size_t n = 0; n < s.node_position.size(); ++n) {
      const double angle = 2 * std::numbers::pi * 0.995 * m.mesh.rest_position[n][0] / 0.4,
                   radius = 0.4 / (2 * std::numbers::pi);
      s.node_position[n] = {float(radius * std::sin(angle) + 1e-3 * noise(n, 0)),
                            float(0.03 * radius * std::cos(angle) + 1e-4 * noise(n, 2)),
                            float(m.mesh.rest_position[n][2] + 1e-3 * noise(n, 1))};
      for (int a = 0; a < 3; ++a) s.node_velocity[n][a] = float(0.05 * noise(n, a + 3));
      s.node_velocity[n][1] = float(s.node_velocity[n][1] - 0.4 * std::cos(angle));
    }
  };
  compare_stage({.stage = Stage::self_collision,
                 .scene = strips,
                 .steps_before = 0,
                 .prepare = flatten,
                 .changes = "node_velocity"});
}

/// Two strips in a file, whose facing edges have points of their own: liquid passes them where they are stitched nearly
/// as it does where they are welded, and not at all where they are neither.
TEST(sewing, liquid_passes_a_seam_as_it_passes_an_edge) {
  const auto folder = std::filesystem::temp_directory_path() / ("drench_sewing_stage_" + std::to_string(::getpid()));
  std::filesystem::create_directories(folder);
  constexpr int columns = 12, rows = 6;
  std::string obj, pairs;
  for (int panel = 0; panel < 2; ++panel)
    for (int j = 0; j <= rows; ++j)
      for (int i = 0; i <= columns; ++i) obj += fmt::format("v {} {} 0\n", 0.02 * i, 0.02 * (j - rows * panel));
  for (int panel = 0; panel < 2; ++panel)
    for (int j = 0; j < rows; ++j)
      for (int i = 0; i < columns; ++i) {
        const int a = (columns + 1) * ((rows + 1) * panel + j) + i + 1, b = a + columns + 1;
        obj += fmt::format("f {} {} {}\nf {} {} {}\n", a, a + 1, b + 1, a, b + 1, b);
      }
  for (int i = 0; i <= columns; ++i)
    pairs += fmt::format("{}[{}, {}]", i == 0 ? "" : ", ", i, (columns + 1) * (2 * rows + 1) + i);
  std::ofstream(folder / "strips.obj") << obj;
  const auto wicked = [&](const std::string& keys) {
    const std::string yaml =
        "drench: 1\ntime: {step: 0.01, end: 2}\ngravity: [0, 0, 0]\ncloth:\n  - mesh: {file: strips.obj}\n" + keys +
        "    pin: [{box: {min: [-1, -1, -1], max: [1, 1, 1]}}]\n"
        "    initial_saturation: [{box: {min: [-1, 0.0001, -1], max: [1, 1, 1]}, value: 1}]\n"
        "    porous: {diffusivity: 1.0e-3}\n";
    const drench::Setup setup = build(parse_scene(yaml, (folder / "scene.yaml").string()));
    const auto backend = make_kokkos_backend(setup.model);
    Pipeline pipeline(setup.model, *backend, setup.state);
    for (int step = 0; step < 100; ++step) pipeline.step(1);
    const HostState s = backend->download();
    double below = 0;
    for (std::size_t n = 0; n < s.node_liquid.size(); ++n)
      if (setup.model.mesh.rest_position[n][1] < -1e-6) below += static_cast<double>(s.node_liquid[n]);
    return below * setup.model.quantum;
  };
  const double welded = wicked(""), stitched = wicked("    weld: off\n    sew: [{pairs: [" + pairs + "]}]\n");
  EXPECT_GT(welded, 1e-4);
  EXPECT_NEAR(stitched / welded, 1, 0.05);
  EXPECT_EQ(wicked("    weld: off\n"), 0);
  std::filesystem::remove_all(folder);
}

/// A sheet becomes a tube: its edges meet, and neither self-collision nor anything else keeps them apart.
TEST(sewing, a_seam_closes_and_holds) {
  const drench::Setup setup = setup_from(strips);
  const Model& m = setup.model;
  ASSERT_EQ(m.mesh.stitch.size(), 5U);
  HostState bent = setup.state;  // a little, so that it knows which way to go; no edge changes its length
  for (Vec3& x : bent.node_position) {
    const double angle = x[0] / 0.05 * 2 * std::asin(0.025 / 0.3);
    x = {0.3 * std::sin(angle), 0.3 * std::cos(angle), x[2]};
  }
  for (const auto& backend : {make_reference_backend(m), make_kokkos_backend(m)}) {
    SCOPED_TRACE(backend->name());
    Pipeline pipeline(m, *backend, bent);
    double before = widest_stitch(m, bent);
    for (int step = 1; step <= 75; ++step) {
      const StepReport report = pipeline.step(1);
      EXPECT_TRUE(report.cloth_converged) << step;
      EXPECT_LT(report.cloth_stretch, 1.2) << step;
      if (step % 25 != 0) continue;
      const double now = widest_stitch(m, backend->download());
      EXPECT_LT(now, step < 50 ? 0.6 * before : 0.002) << step;
      before = now;
    }
  }
}

}  // namespace drench::test
