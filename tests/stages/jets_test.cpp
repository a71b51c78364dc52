// Stage jets: backend against reference from identical input.

#include <gtest/gtest.h>

#include "drench/prescribed.hpp"
#include "stage_compare.hpp"

namespace drench::test {

TEST(jets, agrees_with_the_reference) { compare_stage({.stage = Stage::jets, .steps_before = 11, .changes = "fluid_position"}); }

TEST(jets, that_a_program_changes_agree_with_the_reference) {
  compare_stage({.stage = Stage::jets,
                 .steps_before = 11,
                 .resolve = [](Model& model) { change_jet(model, 0, {0.4, -1.7, 0.2}, Vec3{0.01, 0.3, 0}, 0.01); },
                 .changes = "fluid_position"});
}

}  // namespace drench::test
