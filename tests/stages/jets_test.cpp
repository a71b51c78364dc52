// Stage jets: backend against reference from identical input.

#include <gtest/gtest.h>

#include "drench/prescribed.hpp"
#include "stage_compare.hpp"

namespace drench::test {

TEST(jets, agrees_with_the_reference) {
  compare_stage({.stage = Stage::jets, .steps_before = 11, .changes = "fluid_position"});
}

TEST(jets, that_a_program_changes_agree_with_the_reference) {
  compare_stage({.stage = Stage::jets,
                 .steps_before = 11,
                 .resolve =
                     [](Model& model) {
                       change_jet(model, 0, {0.4, -1.7, 0.2}, Vec3{0.01, 0.3, 0}, 0.01);
                     },
                 .changes = "fluid_position"});
}

/// Particles of several drops each, which leave at an angle.
TEST(jets, of_rain_agrees_with_the_reference) {
  compare_stage(
      {.stage = Stage::jets,
       .scene = with(wet_scene(), "sources:\n",
                     "sources:\n    - rain: {center: [0, 0.2, 0], size: [0.2, 0.3], rate: 200000, diameter: 0.002, "
                     "velocity: [0.3, -2, 0.1]}\n"),
       .steps_before = 11,
       .changes = "fluid_position"});
}

/// Its axis turns, its flow grows, and both keys lie within the steps.
TEST(jets, with_keys_agree_with_the_reference) {
  for (const std::string between : {"linear", "smooth", "step"})
    compare_stage({.stage = Stage::jets,
                   .scene = with(wet_scene(), "velocity: [0, -1.5, 0.1]}",
                                 "velocity: {keys: [[0, [0, 0, 0]], [0.01, [0, -2, 0]], [0.02, [1.5, -2, 1]], "
                                 "[0.05, [0, -4, 0]]], interpolation: " +
                                     between + "}}"),
                   .steps_before = 11,
                   .changes = "fluid_position"});
}

}  // namespace drench::test
