// Stage surface_tension: backend against reference from identical input; forces in pairs cancel.

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "pipeline/backend.hpp"
#include "stage_compare.hpp"

namespace drench::test {
namespace {

/// wet_scene() with tension, a sticky sphere and a sticky sheet.
std::string sticky_scene() {
  std::string scene = with(wet_scene(), "  viscosity: 1.0e-3\n", "  viscosity: 1.0e-3\n  surface_tension: 0.8\n");
  scene = with(scene, "radius: 0.05}", "radius: 0.05, adhesion: 0.5}");
  return with(scene, "    thickness: 0.002\n", "    thickness: 0.002\n    adhesion: 0.3\n");
}

/// Everything at rest, so that velocities are what the stage makes of them, and unequal masses.
void still_with_unequal_masses(const Model&, HostState& s) {
  std::mt19937 random(7);
  std::uniform_int_distribution<Quanta> mass(quanta_per_particle / 20, quanta_per_particle);
  for (Vec3& v : s.fluid_velocity) v = {0, 0, 0};
  for (Vec3& v : s.node_velocity) v = {0, 0, 0};
  for (Vec3& f : s.node_pin_force) f = {0, 0, 0};
  for (Quanta& m : s.fluid_mass) m = mass(random);
}

struct Momentum {
  Vec3 sum{0, 0, 0};
  double size = 0;
  void add(double mass, const Vec3& v) {
    for (int a = 0; a < 3; ++a) sum[a] += mass * v[a];
    size += mass * std::hypot(v[0], v[1], v[2]);
  }
};

Momentum total_momentum(const Model& m, const HostState& s, double dt) {
  Momentum p;
  for (std::size_t i = 0; i < s.fluid_mass.size(); ++i)
    p.add(static_cast<double>(s.fluid_mass[i]) * m.quantum, s.fluid_velocity[i]);
  for (std::size_t n = 0; n < s.node_velocity.size(); ++n) {
    p.add(m.mesh.solid_mass[n] + static_cast<double>(s.node_liquid[n]) * m.quantum, s.node_velocity[n]);
    p.add(-dt, s.node_pin_force[n]);  // what the pins have taken
  }
  return p;
}

}  // namespace

TEST(surface_tension, agrees_with_the_reference) {
  compare_stage_with_every_kernel({.stage = Stage::surface_tension,
                                   .scene = sticky_scene(),
                                   .prepare = still_with_unequal_masses,
                                   .changes = "node_pin_force"});
  compare_stage_with_every_kernel({.stage = Stage::surface_tension,
                                   .scene = sticky_scene(),
                                   .prepare = still_with_unequal_masses,
                                   .changes = "fluid_velocity"});
}

TEST(surface_tension, pairs_of_unequal_masses_conserve_momentum_with_the_cloth) {
  std::string scene = with(sticky_scene(), "  - sphere: {center: [0, -0.06, 0], radius: 0.05, adhesion: 0.5}\n", "");
  scene = with(scene, "pin: [{edges: true}]", "pin: [{corners: true}]");
  const auto setup = setup_from(scene);
  HostState state = setup.state;
  still_with_unequal_masses(setup.model, state);
  const auto backend = make_kokkos_backend(setup.model);
  backend->upload(state);
  StepReport report;
  const StepInfo info{0, 0, 0.002};
  for (const Stage stage : {Stage::neighbors, Stage::density, Stage::surface_tension})
    backend->run(stage, info, report);
  const Momentum p = total_momentum(setup.model, backend->download(), info.dt);
  ASSERT_GT(p.size, 1e-6);
#ifdef DRENCH_DOUBLE
  constexpr double rounding = 1e-14;
#else
  constexpr double rounding = 1e-6;
#endif
  for (const double component : p.sum) EXPECT_LE(std::fabs(component), rounding * p.size);
}

TEST(surface_tension, liquid_is_drawn_to_a_sticky_wall_only) {
  for (const bool sticky : {false, true}) {
    const auto setup = setup_from(std::string(R"(drench: 1
fluid: {spacing: 0.02, sources: [{block: {min: [0, 0, 0], max: [0.2, 0.1, 0.2]}}]}
bodies: [{plane: {point: [0, -0.006, 0], normal: [0, 1, 0], adhesion: )") +
                                  (sticky ? "0.1" : "0") + "}}]\n");
    drench::Setup copy = setup;
    copy.model.scene.fluid.surface_tension = sticky ? 0 : 0.1;
    const auto backend = make_kokkos_backend(copy.model);
    backend->upload(copy.state);
    StepReport report;
    const StepInfo info{0, 0, 0.001};
    for (const Stage stage : {Stage::neighbors, Stage::density, Stage::surface_tension})
      backend->run(stage, info, report);
    double momentum = 0;
    for (const Vec3& v : backend->download().fluid_velocity) momentum += v[1];
    if (sticky)
      EXPECT_LT(momentum, -1e-6);
    else
      EXPECT_NEAR(momentum, 0, 1e-6);
  }
}

}  // namespace drench::test
