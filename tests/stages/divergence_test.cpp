// Stage divergence: backend against reference from identical input.

#include <gtest/gtest.h>

#include "stage_compare.hpp"

namespace drench::test {

TEST(divergence, agrees_with_the_reference) {
  compare_stage_with_every_kernel({.stage = Stage::divergence, .changes = "fluid_velocity"});
}

TEST(divergence, of_crowded_and_light_particles_agrees_with_the_reference) {
  // Four iterations: after six κ with poly6 differs by 1.01e-4 of the largest on a GPU in float.
  compare_stage_with_every_kernel(
      {.stage = Stage::divergence,
       .scene = with(wet_scene(), "max_iterations: 6, min_iterations: 6", "max_iterations: 4, min_iterations: 4"),
       .steps_before = 40,
       .prepare = crowd,
       .changes = "fluid_velocity"});
}

}  // namespace drench::test
