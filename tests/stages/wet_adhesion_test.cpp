// Stage wet_adhesion: backend against reference from identical input, its momentum, and what it leaves alone.

#include <gtest/gtest.h>

#include <cmath>

#include "pipeline/backend.hpp"
#include "precision.hpp"
#include "stage_compare.hpp"
#include "states.hpp"

namespace drench::test {
namespace {

/// Three wet sheets above each other, within reach; under them a floor, and a sphere that moves.
const char* const three_sheets = R"(drench: 1
time: {step: 0.004, end: 1}
domain: {min: [-1, -1, -1], max: [1, 1, 1]}
cloth:
  - name: upper
    mesh: {grid: {size: [0.2, 0.2], nodes: [8, 7]}}
    place: {position: [0.003, 0.006, 0.001], rotate: {axis: [0.02, 1, 0.04], degrees: 17}}
    thickness: 0.004
    self_collision: true
    porous: {adhesion: 0.1}
  - name: middle
    mesh: {grid: {size: [0.22, 0.18], nodes: [7, 8]}}
    thickness: 0.002
    self_collision: true
    pin: [{corners: true}]
    porous: {adhesion: 0.05}
  - name: lower
    mesh: {grid: {size: [0.15, 0.2], nodes: [6, 9]}}
    place: {position: [0.003, -0.005, 0.001], rotate: {axis: [0.01, 1, -0.02], degrees: -23}}
    thickness: 0.003
    self_collision: true
bodies:
  - plane: {point: [0, -0.01, 0], normal: [0.02, 1, 0]}
  - sphere: {center: [0.02, 0.06, 0], radius: 0.049, velocity: [0.1, -0.4, 0],
        spin: {axis: [0, 0, 1], degrees_per_second: 90}}
)";

void soak(const Model& m, HostState& s) {
  for (std::size_t n = 0; n < s.node_position.size(); ++n) {
    for (int a = 0; a < 3; ++a) s.node_position[n][a] = float(s.node_position[n][a] + 4e-4 * noise(n, a));
    const double full = m.samples.node_capacity[n] / m.quantum;
    s.node_liquid[n] = static_cast<Quanta>(full * (0.6 + 0.5 * noise(n, 3)));
  }
}

}  // namespace

TEST(wet_adhesion, agrees_with_the_reference) {
  compare_stage({.stage = Stage::wet_adhesion,
                 .scene = three_sheets,
                 .steps_before = 0,
                 .prepare = soak,
                 .changes = "node_velocity node_pin_force"});
}

TEST(wet_adhesion, leaves_dry_cloth_alone) {
  const auto setup = setup_from(three_sheets);
  for (const auto& backend : {make_reference_backend(setup.model), make_kokkos_backend(setup.model)}) {
    StepReport report;
    backend->upload(setup.state);
    const HostState before = backend->download();
    backend->run(Stage::wet_adhesion, {0, 0, 0.004}, report);
    EXPECT_EQ(backend->download().node_velocity, before.node_velocity) << backend->name();
  }
}

TEST(wet_adhesion, conserves_momentum_between_fabrics_and_pulls_them_together) {
  std::string scene = with(three_sheets, "    pin: [{corners: true}]\n", "");
  scene = scene.substr(0, scene.find("bodies:"));
  const auto setup = setup_from(scene);
  HostState s = setup.state;
  soak(setup.model, s);
  run_on_both(setup.model, s, {Stage::wet_adhesion}, {0, 0, 0.004}, [&](const Backend& backend, const StepReport&) {
    const HostState after = backend.download();
    double size = 0, upper = 0, lower = 0;
    Vec3 sum{0, 0, 0};
    for (std::size_t n = 0; n < s.node_velocity.size(); ++n) {
      const double mass = setup.model.mesh.solid_mass[n] + setup.model.quantum * double(s.node_liquid[n]);
      for (int a = 0; a < 3; ++a) {
        sum[a] += mass * after.node_velocity[n][a];
        size += mass * std::abs(after.node_velocity[n][a]);
      }
      if (setup.model.mesh.node_cloth[n] == 0) upper += mass * after.node_velocity[n][1];
      if (setup.model.mesh.node_cloth[n] == 2) lower += mass * after.node_velocity[n][1];
    }
    EXPECT_LT(upper, -0.05 * size);
    EXPECT_GT(lower, 0.05 * size);
    for (int a = 0; a < 3; ++a) EXPECT_LE(std::abs(sum[a]), allowed(backend, 1e-12, 1e-6) * size);
  });
}

}  // namespace drench::test
