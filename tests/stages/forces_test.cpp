// Stage forces: backend against reference from identical input, and what the viscosity keeps.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "pipeline/backend.hpp"
#include "precision.hpp"
#include "stage_compare.hpp"

namespace drench::test {
namespace {

constexpr const char* thin = "viscosity: 1.0e-3";

double square(const Vec3& v) { return v[0] * v[0] + v[1] * v[1] + v[2] * v[2]; }

struct Motion {
  Vec3 momentum{0, 0, 0}, angular{0, 0, 0};  // kg m/s, kg m²/s; the pins' impulse included
  double energy = 0, scale = 0;              // J; Σ m v, kg m/s
};

Motion motion(const Model& m, const HostState& s, double dt) {
  Motion out;
  const auto add = [&](const Vec3& x, const Vec3& p) {
    for (std::size_t a = 0; a < 3; ++a) {
      out.momentum[a] += p[a];
      out.angular[a] += x[(a + 1) % 3] * p[(a + 2) % 3] - x[(a + 2) % 3] * p[(a + 1) % 3];
    }
    out.scale += std::sqrt(square(p));
  };
  const auto moving = [&](double mass, const Vec3& x, const Vec3& v) {
    add(x, {mass * v[0], mass * v[1], mass * v[2]});
    out.energy += 0.5 * mass * square(v);
  };
  for (std::size_t i = 0; i < s.fluid_position.size(); ++i)
    moving(static_cast<double>(s.fluid_mass[i]) * m.quantum, s.fluid_position[i], s.fluid_velocity[i]);
  for (std::size_t n = 0; n < s.node_position.size(); ++n) {
    moving(m.mesh.solid_mass[n] + static_cast<double>(s.node_liquid[n]) * m.quantum, s.node_position[n],
           s.node_velocity[n]);
    const Vec3& f = s.node_pin_force[n];  // on the node, so what the pin got is its opposite
    add(s.node_position[n], {-dt * f[0], -dt * f[1], -dt * f[2]});
  }
  return out;
}

double difference(const Vec3& a, const Vec3& b) { return std::sqrt(square({a[0] - b[0], a[1] - b[1], a[2] - b[2]})); }

}  // namespace

TEST(forces, agrees_with_the_reference) {
  compare_stage_with_every_kernel({.stage = Stage::forces, .changes = "fluid_velocity"});
}

TEST(forces, agrees_with_the_reference_without_viscosity) {
  compare_stage(
      {.stage = Stage::forces, .scene = with(wet_scene(), thin, "viscosity: 0"), .changes = "fluid_velocity"});
}

TEST(forces, agrees_with_the_reference_in_many_stages) {
  compare_stage(
      {.stage = Stage::forces, .scene = with(wet_scene(), thin, "viscosity: 0.3"), .changes = "node_velocity"});
}

TEST(forces, agrees_with_the_reference_in_a_central_field) {
  for (const std::string viscosity : {"viscosity: 0", thin}) {
    const std::string scene = with(wet_scene(), thin, viscosity);
    compare_stage({.stage = Stage::forces,
                   .scene = with(scene, "fluid:\n", "field: {center: [0.1, 0, -0.2], rate: [3, 0, 5]}\nfluid:\n"),
                   .changes = "fluid_velocity"});
  }
}

TEST(forces, a_step_of_any_viscosity_keeps_momentum_and_adds_no_energy) {
  // 5 g/m² of cloth under water: one explicit step would turn the nodes' velocity over many times.
  int most_stages = 0;
  for (const std::string viscosity : {"1.0e-6", "1.0e-3", "0.1", "10"}) {
    SCOPED_TRACE(viscosity);
    std::vector<int> stages;
    std::string scene = with(wet_scene(), thin, "viscosity: " + viscosity);
    scene = with(scene, "domain:", "gravity: [0, 0, 0]\ndomain:");
    scene = with(scene, "thickness: 0.002", "thickness: 0.002\n    areal_density: 0.005");
    scene = with(scene, "{min: [-0.07, 0.011, -0.06], max: [0.07, 0.151, 0.06]",
                 "{min: [-0.07, 0.01, -0.06], max: [0.07, 0.15, 0.06]");
    const auto setup = setup_from(scene);
    HostState state = setup.state;
    std::fill(state.node_liquid.begin(), state.node_liquid.end(), Quanta{0});
    for (std::size_t i = 0; i < state.fluid_position.size(); ++i) {
      state.fluid_velocity[i] = {std::sin(40.0 * static_cast<double>(i)), std::cos(7.0 * static_cast<double>(i)), 1};
      state.fluid_mass[i] = quanta_per_particle / static_cast<Quanta>(1 + i % 3);
    }
    // Away from the solids, which take momentum.
    for (Vec3& x : state.boundary_position) x[1] -= 0.5;
    const StepInfo info{0, 0, 0.004};
    const std::vector<Stage> run{Stage::neighbors, Stage::density, Stage::forces};
    run_on_both(setup.model, state, run, info, [&](const Backend& backend, const StepReport& report) {
      const HostState after = backend.download();
      stages.push_back(report.viscosity_stages);
      const Motion a = motion(setup.model, state, info.dt), b = motion(setup.model, after, info.dt);
      const double tolerance = allowed(backend, 1e-12, 2e-6);
      EXPECT_LE(difference(a.momentum, b.momentum), tolerance * b.scale);
      EXPECT_LE(difference(a.angular, b.angular), tolerance * b.scale);  // arms are below 1 m
      EXPECT_LT(b.energy, a.energy);
      double change = 0;
      for (std::size_t n = 0; n < state.node_position.size(); ++n)
        change = std::max(change, difference(state.node_velocity[n], after.node_velocity[n]));
      EXPECT_GT(change, 0) << "the cloth feels nothing";
    });
    EXPECT_EQ(stages.front(), stages.back());
    EXPECT_GE(stages.front(), std::max(1, most_stages));
    most_stages = stages.front();
  }
  EXPECT_GT(most_stages, 10);
}

TEST(forces, of_crowded_and_light_particles_agrees_with_the_reference) {
  compare_stage_with_every_kernel({.stage = Stage::forces, .prepare = crowd, .changes = "fluid_velocity"});
}

}  // namespace drench::test
