// Stage surface_tension: backend against reference from identical input; what pairs of forces conserve.

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "pipeline/backend.hpp"
#include "precision.hpp"
#include "stage_compare.hpp"

namespace drench::test {
namespace {

/// wet_scene() with tension, a sticky sphere and a sticky sheet that is pinned in its middle too.
std::string sticky_scene() {
  std::string scene = with(wet_scene(), "  viscosity: 1.0e-3\n", "  viscosity: 1.0e-3\n  surface_tension: 0.8\n");
  scene = with(scene, "radius: 0.05}", "radius: 0.05, adhesion: 0.5}");
  scene = with(scene, "{edges: true}", "{edges: true}, {nodes: [40]}");
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

/// The state after the stage, which starts from `state`.
HostState after_stage(const Model& model, const HostState& state, double dt) {
  const auto backend = make_kokkos_backend(model);
  backend->upload(state);
  StepReport report;
  for (const Stage stage : {Stage::neighbors, Stage::density, Stage::surface_tension})
    backend->run(stage, {0, 0, dt}, report);
  return backend->download();
}

/// Linear and angular momentum, and the sum of the magnitudes of their terms.
struct Momentum {
  Vec3 linear{0, 0, 0}, angular{0, 0, 0};
  double size = 0, moment_size = 0;
  void add(double mass, const Vec3& x, const Vec3& v) {
    for (std::size_t a = 0; a < 3; ++a) {
      const std::size_t b = (a + 1) % 3, c = (a + 2) % 3;
      linear[a] += mass * v[a];
      angular[a] += mass * (x[b] * v[c] - x[c] * v[b]);
    }
    size += std::abs(mass) * std::hypot(v[0], v[1], v[2]);
    moment_size += std::abs(mass) * std::hypot(v[0], v[1], v[2]) * std::hypot(x[0], x[1], x[2]);
  }
};

Momentum momentum_of(const Model& m, const HostState& s, double dt) {
  Momentum p;
  for (std::size_t i = 0; i < s.fluid_mass.size(); ++i)
    p.add(static_cast<double>(s.fluid_mass[i]) * m.quantum, s.fluid_position[i], s.fluid_velocity[i]);
  for (std::size_t n = 0; n < s.node_velocity.size(); ++n) {
    p.add(m.mesh.solid_mass[n] + static_cast<double>(s.node_liquid[n]) * m.quantum, s.node_position[n],
          s.node_velocity[n]);
    p.add(-dt, s.node_position[n], s.node_pin_force[n]);  // what the pins have taken
  }
  return p;
}

const double rounding = double_precision ? 1e-14 : 1e-6;

/// A floor under a block of water at rest, both without gravity.
std::string floor_scene(double tension, double adhesion) {
  return "drench: 1\ngravity: [0, 0, 0]\ntime: {step: 0.001, end: 1}\nfluid:\n  spacing: 0.02\n  surface_tension: " +
         std::to_string(tension) +
         "\n  sources: [{block: {min: [0, 0, 0], max: [0.2, 0.1, 0.2]}}]\nbodies: [{plane: {point: [0, 0, 0], normal: "
         "[0, 1, 0], adhesion: " +
         std::to_string(adhesion) + "}}]\n";
}

}  // namespace

TEST(surface_tension, agrees_with_the_reference) {
  for (const char* field : {"fluid_velocity", "node_velocity", "node_pin_force"})
    compare_stage_with_every_kernel({.stage = Stage::surface_tension,
                                     .scene = sticky_scene(),
                                     .prepare = still_with_unequal_masses,
                                     .changes = field});
}

TEST(surface_tension, agrees_with_the_reference_where_walls_wet_completely) {
  compare_stage({.stage = Stage::surface_tension,
                 .scene = with(with(sticky_scene(), "adhesion: 0.5", "adhesion: 3"), "adhesion: 0.3", "adhesion: 2.5"),
                 .prepare = still_with_unequal_masses,
                 .changes = "fluid_velocity"});
}

TEST(surface_tension, agrees_with_the_reference_where_only_cloth_or_only_solids_are_sticky) {
  const std::string no_tension = with(sticky_scene(), "surface_tension: 0.8", "surface_tension: 0");
  compare_stage({.stage = Stage::surface_tension,
                 .scene = with(no_tension, ", adhesion: 0.5}", "}"),
                 .prepare = still_with_unequal_masses,
                 .changes = "node_velocity"});
  compare_stage({.stage = Stage::surface_tension,
                 .scene = with(no_tension, "    adhesion: 0.3\n", ""),
                 .prepare = still_with_unequal_masses,
                 .changes = "fluid_velocity"});
}

TEST(surface_tension, unequal_masses_conserve_momentum_and_angular_momentum) {
  std::string scene = with(wet_scene(), "  viscosity: 1.0e-3\n", "  surface_tension: 0.8\n");
  for (const char* kernel : {"cubic", "wendland", "poly6"}) {
    SCOPED_TRACE(kernel);
    const auto setup = setup_from(with(scene, "fluid:\n", std::string("fluid:\n  kernel: ") + kernel + "\n"));
    HostState state = setup.state;
    still_with_unequal_masses(setup.model, state);
    std::mt19937 random(3);
    std::uniform_real_distribution<double> shift(-0.004, 0.004);
    for (Vec3& x : state.fluid_position)
      for (double& component : x) component += shift(random);
    const Momentum p = momentum_of(setup.model, after_stage(setup.model, state, 0.002), 0.002);
    ASSERT_GT(p.size, 1e-4);
    for (std::size_t a = 0; a < 3; ++a) {
      EXPECT_LE(std::abs(p.linear[a]), rounding * p.size);
      EXPECT_LE(std::abs(p.angular[a]), rounding * p.moment_size);
    }
  }
}

TEST(surface_tension, what_the_liquid_gains_the_sticky_cloth_loses) {
  const std::string scene =
      with(sticky_scene(), "  - sphere: {center: [0, -0.06, 0], radius: 0.05, adhesion: 0.5}\n", "");
  const auto setup = setup_from(scene);
  HostState state = setup.state;
  still_with_unequal_masses(setup.model, state);
  const HostState end = after_stage(setup.model, state, 0.002);
  const Momentum p = momentum_of(setup.model, end, 0.002);
  double cloth = 0, pins = 0;  // upward: towards the liquid above the sheet
  for (std::size_t n = 0; n < end.node_velocity.size(); ++n) {
    cloth += (setup.model.mesh.solid_mass[n] + static_cast<double>(end.node_liquid[n]) * setup.model.quantum) *
             end.node_velocity[n][1];
    pins -= end.node_pin_force[n][1];
  }
  EXPECT_GT(cloth, 1e-3 * p.size);
  EXPECT_GT(pins, 0);
  for (const double component : p.linear) EXPECT_LE(std::abs(component), rounding * p.size);
}

TEST(surface_tension, liquid_is_drawn_to_a_sticky_wall_only) {
  for (const double adhesion : {0.0, 0.1}) {
    const auto setup = setup_from(floor_scene(0.1, adhesion));
    const Momentum p = momentum_of(setup.model, after_stage(setup.model, setup.state, 0.001), 0.001);
    if (adhesion > 0) {
      EXPECT_LT(p.linear[1], -0.05 * p.size);
    } else {
      EXPECT_NEAR(p.linear[1], 0, rounding * p.size);
    }
  }
}

// A wall with η_b = 1 completes the lattice: what touches it feels neither a pull nor a surface. With η_b = 2 both are
// reversed.
TEST(surface_tension, a_wall_that_pulls_like_liquid_is_like_liquid) {
  const auto rise = [](double adhesion) {  // m/s, of the first layer's middle
    const auto setup = setup_from(floor_scene(0.1, adhesion));
    const HostState end = after_stage(setup.model, setup.state, 0.001);
    double sum = 0, count = 0;
    for (std::size_t i = 0; i < end.fluid_position.size(); ++i) {
      const Vec3& x = end.fluid_position[i];
      if (x[1] > 0.02 || std::abs(x[0] - 0.1) > 0.02 || std::abs(x[2] - 0.1) > 0.02) continue;
      sum += end.fluid_velocity[i][1];
      ++count;
    }
    EXPECT_GE(count, 4);
    return sum / count;
  };
  constexpr double wall_share = 0.88;  // β_w of docs/theory/surface_tension.md
  const double alone = rise(0);
  EXPECT_GT(std::abs(alone), 1e-6);
  // The samples lie half a spacing beside the lattice: the kernel's sum is 3 % smaller there.
  EXPECT_LT(std::abs(rise(0.1 / wall_share)), 0.06 * std::abs(alone));
  EXPECT_NEAR(rise(0.2 / wall_share), -alone, 0.12 * std::abs(alone));
}

}  // namespace drench::test
