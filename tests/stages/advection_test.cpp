// Stage advection: backend against reference from identical input.

#include <gtest/gtest.h>

#include "pipeline/backend.hpp"
#include "stage_compare.hpp"

namespace drench::test {

TEST(advection, agrees_with_the_reference) { compare_stage({.stage = Stage::advection, .changes = "fluid_position"}); }

TEST(advection, fast_particles_stopped_at_the_cloth_agree_with_the_reference) {
  compare_stage({.stage = Stage::advection,
                 .prepare =
                     [](const Model&, HostState& s) {
                       for (std::size_t i = 0; i < s.fluid_velocity.size(); i += 3)
                         s.fluid_velocity[i] = {0.3, -12, 0.2};
                     },
                 .changes = "node_velocity"});
}

TEST(advection, no_particle_passes_an_unbroken_cloth) {
  const auto setup =
      setup_from(with(wet_scene(), "pin: [{edges: true}]", "pin: [{box: {min: [-1, -1, -1], max: [1, 1, 1]}}]"));
  for (const auto& backend : {make_reference_backend(setup.model), make_kokkos_backend(setup.model)}) {
    HostState state = setup.state;
    for (Vec3& v : state.fluid_velocity) v = {0, -40, 0};  // four spacings a step
    StepReport report;
    backend->upload(state);
    backend->run(Stage::neighbors, {0, 0, 0.002}, report);
    backend->run(Stage::density, {0, 0, 0.002}, report);
    backend->run(Stage::advection, {0, 0, 0.002}, report);
    EXPECT_GT(report.collisions, 50) << backend->name();
    for (const Vec3& x : backend->download().fluid_position) EXPECT_GT(x[1], 0) << backend->name();
  }
}

TEST(advection, what_leaves_the_domain_enters_the_account_of_drained_liquid) {
  compare_stage({.stage = Stage::advection,
                 .steps_before = 3,
                 .prepare =
                     [](const Model&, HostState& s) {
                       for (std::size_t i = 0; i < s.fluid_velocity.size(); i += 5) s.fluid_velocity[i] = {900, 0, 0};
                     },
                 .changes = "fluid_mass"});
}

}  // namespace drench::test
