// Stage pressure: backend against reference from identical input.

#include <gtest/gtest.h>

#include "stage_compare.hpp"

namespace drench::test {

TEST(pressure, agrees_with_the_reference) {
  compare_stage_with_every_kernel({.stage = Stage::pressure, .steps_before = 40, .changes = "fluid_velocity"});
}

TEST(pressure, of_crowded_and_light_particles_agrees_with_the_reference) {
  // After 41 steps: after 40, with `cubic`, the cloth's residual is so near its goal at a check that single and double
  // precision stop ten iterations apart.
  compare_stage_with_every_kernel(
      {.stage = Stage::pressure, .steps_before = 41, .prepare = crowd, .changes = "fluid_velocity"});
}

TEST(pressure, with_cloth_by_xpbd_agrees_with_the_reference) {
  compare_stage({.stage = Stage::pressure,
                 .scene = with(wet_scene(), "cloth:\n", "cloth_solver: {method: xpbd}\ncloth:\n"),
                 .steps_before = 40,
                 .changes = "fluid_velocity"});
}

}  // namespace drench::test
