// Stage jets: backend against reference from identical input.

#include <gtest/gtest.h>

#include "stage_compare.hpp"

namespace drench::test {

TEST(jets, agrees_with_the_reference) { compare_stage({.stage = Stage::jets, .steps_before = 11, .changes = "fluid_position"}); }

}  // namespace drench::test
