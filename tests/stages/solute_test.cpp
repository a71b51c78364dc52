// The solute of the liquid: every stage that moves liquid, backend against reference; its total, and liquid that stays
// uniform.

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "pipeline/pipeline.hpp"
#include "porous/transfer.hpp"
#include "quanta_sum.hpp"
#include "stage_compare.hpp"
#include "states.hpp"

namespace drench::test {
namespace {

/// The wet scene with a block of a third of the jet's concentration, a dyed reservoir and a stain.
std::string dyed_scene() {
  std::string yaml =
      with(wet_scene(), "velocity: [0.1, -0.6, 0.05]}", "velocity: [0.1, -0.6, 0.05], concentration: 0.01}");
  yaml = with(yaml, "velocity: [0, -1.5, 0.1]}", "velocity: [0, -1.5, 0.1], concentration: 0.03}");
  yaml = with(yaml, "value: 0.6}]",
              "value: 0.6, concentration: 0.02}]\n    initial_stain: [{box: {min: [0, -1, -1], max: [1, 1, 1]}, value: "
              "2.0e-3}]");
  return with(yaml, "max: [0.05, 1, 0.05]}, value: 1.1}", "max: [0.05, 1, 0.05]}, value: 1.1, concentration: 0.007}");
}

/// For `prepare`: another concentration in each particle and each node, also of nodes without liquid.
void dye(const Model& m, HostState& s) {
  for (std::size_t i = 0; i < s.fluid_solute.size(); ++i)
    s.fluid_solute[i] = static_cast<Quanta>((1 + noise(i, 0)) * double(s.fluid_mass[i]));
  for (std::size_t n = 0; n < s.node_solute.size(); ++n)
    s.node_solute[n] = static_cast<Quanta>((1 + noise(n, 1)) *
                                           (double(s.node_liquid[n]) + 0.1 * m.samples.node_capacity[n] / m.quantum));
}

Quanta solute_of(const HostState& s) {
  return sum(s.fluid_solute) + sum(s.node_solute) + s.solute_drained + s.solute_deposited - s.solute_supplied;
}

constexpr const char* two_sheets = R"(drench: 1
time: {step: 0.01, end: 1}
cloth:
  - name: lower
    mesh: {grid: {size: [0.2, 0.1], nodes: [11, 6]}}
    dynamics: false
    porous: {contact_wicking: true}
  - name: upper
    mesh: {grid: {size: [0.2, 0.1], nodes: [9, 5]}}
    place: {position: [0, 0.001, 0]}
    dynamics: false
    initial_saturation: [{box: {min: [-1, -1, -1], max: [0.05, 1, 1]}, value: 1, concentration: 0.01}]
    hold_saturation: [{box: {min: [0.08, -1, -1], max: [1, 1, 1]}, value: 0.4, concentration: 0.02}]
    porous: {contact_wicking: true, solid_fraction: 0.7, diffusivity: 3.0e-5}
)";

}  // namespace

TEST(solute, parts_are_exact) {
  using namespace kokkos_backend;
  EXPECT_EQ(solute_part(10, 3, 3), 10);
  EXPECT_EQ(solute_part(10, 1, 3), 3);
  EXPECT_EQ(solute_part(10, 0, 3), 0);
  EXPECT_EQ(solute_part(0, 2, 3), 0);
  EXPECT_EQ(solute_part(0, 0, 0), 0);
  const Quanta parts[3] = {Quanta{1} << 40, 0, (Quanta{1} << 41) + 5};
  const Quanta whole = (Quanta{1} << 50) + 7;
  EXPECT_EQ(solute_beside(whole, parts, 0) + solute_beside(whole, parts, 1) + solute_beside(whole, parts, 2), whole);
  EXPECT_EQ(solute_beside(whole, parts, 1), 0);
}

TEST(solute, a_scene_names_it) {
  EXPECT_FALSE(setup_from(wet_scene()).model.has_solute());
  EXPECT_TRUE(setup_from(wet_scene()).state.fluid_solute.empty());
  EXPECT_TRUE(setup_from(wet_scene()).state.node_solute.empty());
  const auto setup = setup_from(dyed_scene());
  const Model& m = setup.model;
  EXPECT_DOUBLE_EQ(m.concentration_unit, 0.03);
  EXPECT_NEAR(double(setup.state.fluid_solute[0]) / double(setup.state.fluid_mass[0]), 1. / 3, 1e-9);
  EXPECT_EQ(m.jets[0].solute, quanta_per_particle);
  double stained = 0, held = 0, expected = 0;
  for (std::size_t n = 0; n < setup.state.node_solute.size(); ++n) {
    const double kilograms = double(setup.state.node_solute[n]) * m.solute_quantum(),
                 liquid = double(setup.state.node_liquid[n]) * m.quantum;
    const Vec3& x = m.mesh.rest_position[n];
    (x[0] < 0 ? held : stained) += kilograms;
    if (x[0] < 0) expected += liquid * (x[2] >= 0.12 ? 0.02 : 0.007);
  }
  EXPECT_NEAR(held, expected, 1e-6 * expected);
  EXPECT_GT(stained, 2e-3 * 0.3 * 0.15);
}

TEST(solute, goes_with_the_liquid_in_each_stage_as_in_the_reference) {
  const std::string scene = dyed_scene();
  compare_stage({.stage = Stage::absorption, .scene = scene, .prepare = dye, .changes = "fluid_solute node_solute"});
  compare_stage({.stage = Stage::jets, .scene = scene, .steps_before = 11, .changes = "fluid_solute"});
  compare_stage({.stage = Stage::diffusion, .scene = scene, .prepare = dye, .changes = "node_solute"});
  compare_stage({.stage = Stage::reservoir, .scene = scene, .prepare = dye, .changes = "node_solute"});
  compare_stage({.stage = Stage::ledger, .scene = scene, .prepare = dye});
  compare_stage({.stage = Stage::advection,
                 .scene = scene,
                 .steps_before = 3,
                 .prepare =
                     [](const Model& m, HostState& s) {
                       dye(m, s);
                       for (std::size_t i = 0; i < s.fluid_velocity.size(); i += 5) s.fluid_velocity[i] = {900, 0, 0};
                     },
                 .changes = "fluid_solute"});
}

TEST(solute, where_nodes_are_nearly_full_absorption_takes_what_the_liquid_allows) {
  compare_stage({.stage = Stage::absorption,
                 .scene = dyed_scene(),
                 .prepare =
                     [](const Model& m, HostState& s) {
                       for (std::size_t n = 0; n < s.node_liquid.size(); ++n)
                         s.node_liquid[n] = static_cast<Quanta>((n % 3 == 0 ? 1.1799999 : 0.9) *
                                                                m.samples.node_capacity[n] / m.quantum);
                       crowd(m, s);
                       dye(m, s);
                     },
                 .changes = "fluid_solute node_solute"});
}

TEST(solute, emission_gives_it_to_liquid_layers_and_new_particles_as_the_reference_does) {
  const auto drip = [](const Model& m, HostState& s) {
    overfill(m, s, 8);
    for (std::size_t i = 0; i < s.fluid_position.size(); ++i)
      if (i % 2 == 0)
        s.fluid_position[i][1] += 0.2;  // room below the sheet
      else
        s.fluid_mass[i] -= s.fluid_mass[i] / 9;
    dye(m, s);
  };
  const std::string layers =
      with(dyed_scene(), "bodies:\n",
           "  - name: below\n    mesh: {grid: {size: [0.13, 0.28], nodes: [7, 13]}}\n    place: {position: [-0.08, "
           "-0.02, 0]}\n    pin: [{edges: true}]\n    porous: {}\nbodies:\n");
  for (const std::string& scene : {dyed_scene(), layers}) {
    compare_stage({.stage = Stage::emission,
                   .scene = scene,
                   .steps_before = 2,
                   .prepare = drip,
                   .changes = "fluid_solute node_solute fluid_id"});
    const auto setup = setup_from(scene);
    HostState s = setup.state;
    drip(setup.model, s);
    const Quanta before = solute_of(s);
    run_on_both(setup.model, s, {Stage::neighbors, Stage::porous_neighbors, Stage::flow_direction, Stage::emission},
                {0, 0, 0.002},
                [&](const Backend& backend, const StepReport&) { EXPECT_EQ(solute_of(backend.download()), before); });
  }
}

TEST(solute, layers_in_contact_pass_it_on_as_in_the_reference) {
  compare_stage({.stage = Stage::diffusion, .scene = two_sheets, .prepare = dye, .changes = "node_solute"});
}

TEST(solute, pressure_drives_it_through_cloth_as_in_the_reference) {
  const std::string scene = with(dyed_scene(), "porous: {", "porous: {permeability: 1.0e-8, ");
  compare_stage({.stage = Stage::absorption, .scene = scene, .prepare = dye, .changes = "fluid_solute node_solute"});
  compare_stage({.stage = Stage::emission,
                 .scene = scene,
                 .prepare =
                     [](const Model& m, HostState& s) {
                       overfill(m, s, 4);
                       dye(m, s);
                     },
                 .changes = "node_solute"});
}

namespace {

/// Steps of a scene on the backend: the total never changes, and nothing falls below 0.
HostState run_and_count(const std::string& yaml, int steps) {
  const auto setup = setup_from(yaml);
  const auto backend = make_kokkos_backend(setup.model);
  Pipeline pipeline(setup.model, *backend, setup.state);
  HostState s;
  for (int k = 0; k < steps; ++k) {
    const StepReport r = pipeline.step(1);  // throws where the total changes
    EXPECT_EQ(r.solute_total(), pipeline.initial_solute());
    s = backend->download();
    EXPECT_EQ(solute_of(s), pipeline.initial_solute());
    EXPECT_EQ(r.solute_fluid, sum(s.fluid_solute));
    EXPECT_EQ(r.solute_cloth, sum(s.node_solute));
    for (const auto* all : {&s.fluid_solute, &s.node_solute})
      EXPECT_TRUE(std::all_of(all->begin(), all->end(), [](Quanta q) { return q >= 0; }));
    if (testing::Test::HasFailure()) break;
  }
  return s;
}

}  // namespace

TEST(solute, of_drops_that_dry_whole_is_deposited) {
  const std::string drops = R"(drench: 1
time: {step: 0.002, end: 1}
gravity: [0, 0, 0]
air: {evaporation_rate: 100}
fluid: {spacing: 0.01, sources: [{block: {min: [0, 0, 0], max: [0.02, 0.02, 0.02], concentration: 0.01}}]}
)";
  // A drop by itself dries by all of its surface, in some ten steps.
  const HostState dry = run_and_count(with(drops, "max: [0.02, 0.02, 0.02]", "max: [0.01, 0.01, 0.01]"), 60);
  EXPECT_EQ(dry.fluid_count(), 0);
  EXPECT_GT(dry.solute_deposited, 0);
  EXPECT_EQ(dry.solute_drained, 0);
  const std::vector<Stage> stages{Stage::neighbors, Stage::density, Stage::evaporation, Stage::advection};
  std::vector<Quanta> deposited;
  const auto setup = setup_from(drops);
  HostState s = setup.state;
  for (std::size_t i = 0; i < s.fluid_mass.size(); i += 2) s.fluid_mass[i] = setup.model.min_quanta;  // these go whole
  run_on_both(setup.model, s, stages, {0, 0, 0.002}, [&](const Backend& backend, const StepReport&) {
    deposited.push_back(backend.download().solute_deposited);
  });
  EXPECT_GT(deposited.at(0), 0);
  EXPECT_EQ(deposited.at(1), deposited.at(0));
}

TEST(solute, its_total_is_exact) {
  const HostState wet = run_and_count(dyed_scene(), 60);
  EXPECT_GT(wet.solute_supplied, 0);
  run_and_count(with(dyed_scene(), "porous: {", "porous: {permeability: 1.0e-8, "), 60);
  run_and_count(two_sheets, 60);
  const HostState gone =
      run_and_count(with(dyed_scene(), "domain: {min: [-1, -1, -1]", "domain: {min: [-1, -0.05, -1]"), 60);
  EXPECT_GT(gone.solute_drained, 0);
}

TEST(solute, uniform_liquid_stays_uniform) {
  // A third of the unit, which only a jet that never flows has. Liquid is taken up, spreads, drips and is taken up
  // again.
  std::string yaml = dyed_scene();
  yaml = with(yaml, "concentration: 0.03}", "concentration: 0.03, start: 100}");
  yaml =
      with(yaml, "concentration: 0.02}]\n    initial_stain: [{box: {min: [0, -1, -1], max: [1, 1, 1]}, value: 2.0e-3}]",
           "concentration: 0.01}]");
  yaml = with(yaml, "concentration: 0.007}", "concentration: 0.01}");
  constexpr int steps = 80;
  const HostState s = run_and_count(yaml, steps);
  ASSERT_TRUE(std::any_of(s.fluid_origin.begin(), s.fluid_origin.end(),
                          [](auto o) { return o == static_cast<std::uint8_t>(Origin::cloth); }));
  double most = 0;  // quanta
  const auto look = [&](const std::vector<Quanta>& solute, const std::vector<Quanta>& liquid) {
    for (std::size_t k = 0; k < solute.size(); ++k)
      most = std::max(most, std::fabs(double(solute[k]) - double(liquid[k]) / 3));
  };
  look(s.fluid_solute, s.fluid_mass);
  look(s.node_solute, s.node_liquid);
  // A quantum at most for each part that comes or goes: fewer than 100 a step and holder, of 4·10⁹ in a particle.
  EXPECT_LT(most, 100 * steps);
  EXPECT_GT(most, 0);
  std::printf("uniform liquid: %.0f quanta apart after %d steps\n", most, steps);
}

TEST(solute, what_is_dry_dissolves_when_liquid_returns) {
  const auto setup = setup_from(R"(drench: 1
time: {step: 0.02, end: 1}
gravity: [0, 0, 0]
cloth:
  - mesh: {grid: {size: [0.1, 0.02], nodes: [11, 3]}}
    dynamics: false
    hold_saturation: [{box: {min: [-1, -1, -1], max: [-0.049, 1, 1]}, value: 1}]
    initial_stain: [{box: {min: [-0.031, -1, -1], max: [-0.019, 1, 1]}, value: 0.01}]
    porous: {diffusivity: 1.0e-3}
)");
  for (const auto& backend : {make_reference_backend(setup.model), make_kokkos_backend(setup.model)}) {
    SCOPED_TRACE(backend->name());
    Pipeline pipeline(setup.model, *backend, setup.state);
    const auto centre = [&](const HostState& s) {
      double first = 0, all = 0;
      for (std::size_t n = 0; n < s.node_solute.size(); ++n) {
        all += double(s.node_solute[n]);
        first += double(s.node_solute[n]) * setup.model.mesh.rest_position[n][0];
      }
      return first / all;
    };
    const double before = centre(setup.state);
    for (int k = 0; k < 100; ++k) pipeline.step(1);
    const HostState after = backend->download();
    EXPECT_EQ(sum(after.node_solute), sum(setup.state.node_solute));
    EXPECT_GT(centre(after), before + 0.01);
  }
}

}  // namespace drench::test
