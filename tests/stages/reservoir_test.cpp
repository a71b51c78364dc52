// Stage reservoir: backend against reference from identical input.

#include <gtest/gtest.h>

#include "stage_compare.hpp"

namespace drench::test {

TEST(reservoir, agrees_with_the_reference) { compare_stage({.stage = Stage::reservoir, .changes = "node_liquid"}); }

}  // namespace drench::test
