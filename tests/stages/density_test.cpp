// Stage density: backend against reference from identical input.

#include <gtest/gtest.h>

#include "stage_compare.hpp"

namespace drench::test {

TEST(density, agrees_with_the_reference) {
  compare_stage_with_every_kernel({.stage = Stage::density, .changes = "fluid_density_ratio"});
}

TEST(density, of_crowded_and_light_particles_agrees_with_the_reference) {
  compare_stage_with_every_kernel({.stage = Stage::density, .prepare = crowd, .changes = "fluid_density_ratio"});
}

}  // namespace drench::test
