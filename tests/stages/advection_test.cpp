// Stage advection: backend against reference from identical input.

#include <gtest/gtest.h>

#include "stage_compare.hpp"

namespace drench::test {

TEST(advection, agrees_with_the_reference) { compare_stage({.stage = Stage::advection, .changes = "fluid_position"}); }

}  // namespace drench::test
