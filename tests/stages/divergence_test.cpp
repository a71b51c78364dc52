// Stage divergence: backend against reference from identical input.

#include <gtest/gtest.h>

#include "stage_compare.hpp"

namespace drench::test {

TEST(divergence, agrees_with_the_reference) {
  compare_stage_with_every_kernel({.stage = Stage::divergence, .changes = "fluid_velocity"});
}

TEST(divergence, of_crowded_and_light_particles_agrees_with_the_reference) {
  compare_stage_with_every_kernel({.stage = Stage::divergence, .steps_before = 40, .prepare = crowd, .changes = "fluid_velocity"});
}

}  // namespace drench::test
