// Stage micropolar: backend against reference from identical input, and what spins and flow keep between them.

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "pipeline/backend.hpp"
#include "precision.hpp"
#include "stage_compare.hpp"

namespace drench::test {
namespace {

/// wet_scene() with spins.
std::string spinning_scene(const std::string& keys) {
  return with(wet_scene(), "  viscosity: 1.0e-3\n", "  viscosity: 1.0e-3\n  micropolar: {" + keys + "}\n");
}

/// Velocities and spins that differ from particle to particle, and unequal masses.
void stir(const Model&, HostState& s) {
  std::mt19937 random(5);
  std::uniform_real_distribution<double> one(-1, 1);
  s.fluid_spin.resize(s.fluid_position.size());
  for (std::size_t i = 0; i < s.fluid_position.size(); ++i) {
    for (std::size_t a = 0; a < 3; ++a) {
      s.fluid_velocity[i][a] += 0.5 * one(random);
      s.fluid_spin[i][a] = 30 * one(random);
    }
    s.fluid_mass[i] = quanta_per_particle / static_cast<Quanta>(1 + i % 3);
  }
}

/// As the orbits and the spins have it, with the sum of the terms' magnitudes; J and kg m²/s.
struct Motion {
  Vec3 momentum{0, 0, 0}, orbits{0, 0, 0}, spins{0, 0, 0};
  double energy = 0, momentum_size = 0, angular_size = 0;
  double angular(std::size_t a) const { return orbits[a] + spins[a]; }
};

Motion motion(const Model& m, const HostState& s) {
  Motion out;
  const double inertia = m.scene.fluid.micropolar.inertia * m.spacing * m.spacing;
  for (std::size_t i = 0; i < s.fluid_position.size(); ++i) {
    const double mass = static_cast<double>(s.fluid_mass[i]) * m.quantum;
    const Vec3 &x = s.fluid_position[i], &v = s.fluid_velocity[i], &w = s.fluid_spin[i];
    for (std::size_t a = 0; a < 3; ++a) {
      const std::size_t b = (a + 1) % 3, c = (a + 2) % 3;
      out.momentum[a] += mass * v[a];
      out.orbits[a] += mass * (x[b] * v[c] - x[c] * v[b]);
      out.spins[a] += mass * inertia * w[a];
      out.momentum_size += mass * std::abs(v[a]);
      out.angular_size += mass * (std::abs(x[b] * v[c]) + std::abs(x[c] * v[b]) + inertia * std::abs(w[a]));
      out.energy += 0.5 * mass * (v[a] * v[a] + inertia * w[a] * w[a]);
    }
  }
  return out;
}

double accuracy(const Backend& backend) { return allowed(backend, 1e-13, 2e-6); }

/// The stage from `state` on both backends: check(backend, state after it).
template <class Check>
void after_stage(const Model& model, const HostState& state, double dt, const Check& check) {
  run_on_both(model, state, {Stage::neighbors, Stage::density, Stage::micropolar}, {0, 0, dt},
              [&](const Backend& backend, const StepReport&) { check(backend, backend.download()); });
}

}  // namespace

TEST(micropolar, agrees_with_the_reference) {
  compare_stage_with_every_kernel({.stage = Stage::micropolar,
                                   .scene = spinning_scene("transfer: 1.0e-3, viscosity: 2.0e-4, reaction: 0.3"),
                                   .prepare = stir,
                                   .changes = "fluid_velocity fluid_spin"});
}

TEST(micropolar, agrees_with_the_reference_in_many_stages) {
  for (const char* keys : {"transfer: 0.2, inertia: 0.1", "transfer: 1.0e-3, viscosity: 0.5, reaction: 1"})
    compare_stage({.stage = Stage::micropolar,
                   .scene = spinning_scene(keys),
                   .prepare = stir,
                   .changes = "fluid_velocity fluid_spin"});
}

TEST(micropolar, of_crowded_and_light_particles_agrees_with_the_reference) {
  compare_stage({.stage = Stage::micropolar,
                 .scene = spinning_scene("transfer: 1.0e-3, viscosity: 2.0e-4"),
                 .prepare =
                     [](const Model& model, HostState& state) {
                       stir(model, state);
                       crowd(model, state);
                     },
                 .changes = "fluid_velocity fluid_spin"});
}

TEST(micropolar, reports_its_stages) {
  int fewer = 0;
  for (const char* keys : {"transfer: 1.0e-4, viscosity: 1.0e-4", "transfer: 10, inertia: 100, viscosity: 1"}) {
    const auto setup = setup_from(spinning_scene(keys));
    std::vector<int> stages;
    for (const auto& backend : {make_reference_backend(setup.model), make_kokkos_backend(setup.model)}) {
      StepReport report;
      backend->upload(setup.state);
      for (const Stage stage : {Stage::neighbors, Stage::density, Stage::micropolar})
        backend->run(stage, {0, 0, 0.004}, report);
      stages.push_back(report.micropolar_stages);
    }
    EXPECT_EQ(stages.front(), stages.back());
    EXPECT_GT(stages.front(), fewer);
    fewer = stages.front();
  }
  EXPECT_GT(fewer, 10);
}

TEST(micropolar, with_the_whole_reaction_both_momenta_are_kept_and_no_energy_is_added) {
  // From one stage to dozens.
  for (const char* keys : {"transfer: 1.0e-4, viscosity: 1.0e-4", "transfer: 1.0e-2, inertia: 0.05",
                           "transfer: 10, inertia: 100, viscosity: 1"}) {
    SCOPED_TRACE(keys);
    const auto setup = setup_from(spinning_scene(keys + std::string(", reaction: 1")));
    HostState state = setup.state;
    stir(setup.model, state);
    const Motion before = motion(setup.model, state);
    after_stage(setup.model, state, 0.004, [&](const Backend& backend, const HostState& after) {
      const Motion end = motion(setup.model, after);
      for (std::size_t a = 0; a < 3; ++a) {
        EXPECT_NEAR(end.momentum[a], before.momentum[a], accuracy(backend) * before.momentum_size);
        EXPECT_NEAR(end.angular(a), before.angular(a), accuracy(backend) * before.angular_size);
      }
      EXPECT_LT(end.energy, before.energy);
      EXPECT_GT(before.energy - end.energy, 1e-4 * before.energy);
    });
  }
}

TEST(micropolar, without_the_reaction_momentum_is_kept_and_what_spins_give_leaves_them) {
  const auto setup = setup_from(spinning_scene("transfer: 1.0e-3, viscosity: 1.0e-4"));
  HostState state = setup.state;
  stir(setup.model, state);
  const Motion stirred = motion(setup.model, state);
  after_stage(setup.model, state, 0.002, [&](const Backend& backend, const HostState& after) {
    const Motion end = motion(setup.model, after);
    for (std::size_t a = 0; a < 3; ++a)
      EXPECT_NEAR(end.momentum[a], stirred.momentum[a], accuracy(backend) * stirred.momentum_size);
  });
  // The flow at rest winds no spins up.
  for (std::size_t i = 0; i < state.fluid_position.size(); ++i) {
    state.fluid_velocity[i] = {0, 0, 0};
    state.fluid_spin[i][1] += 40;
  }
  const Motion still = motion(setup.model, state);
  after_stage(setup.model, state, 0.002, [&](const Backend& backend, const HostState& after) {
    const Motion end = motion(setup.model, after);
    EXPECT_GT(end.orbits[1], 1e-3 * still.spins[1]);  // 2 ν_t Δt/Θ is 1e-2, less at the surface
    for (std::size_t a = 0; a < 3; ++a)
      EXPECT_NEAR(end.angular(a), still.angular(a), accuracy(backend) * still.angular_size);
  });
}

TEST(micropolar, spins_do_not_slip_in_a_rigid_rotation) {
  const auto setup = setup_from(spinning_scene("transfer: 0.01, reaction: 1"));
  HostState state = setup.state;
  const Vec3 turn{3, -5, 8};  // rad/s
  for (std::size_t i = 0; i < state.fluid_position.size(); ++i) {
    const Vec3& x = state.fluid_position[i];
    for (std::size_t a = 0; a < 3; ++a) {
      const std::size_t b = (a + 1) % 3, c = (a + 2) % 3;
      state.fluid_velocity[i][a] = turn[b] * x[c] - turn[c] * x[b];
    }
    state.fluid_spin[i] = turn;
  }
  after_stage(setup.model, state, 0.004, [&](const Backend& backend, const HostState& after) {
    for (std::size_t i = 0; i < state.fluid_position.size(); ++i)
      for (std::size_t a = 0; a < 3; ++a) {
        EXPECT_NEAR(after.fluid_velocity[i][a], state.fluid_velocity[i][a], 2 * accuracy(backend));
        EXPECT_NEAR(after.fluid_spin[i][a], state.fluid_spin[i][a], 100 * accuracy(backend));
      }
  });
}

}  // namespace drench::test
