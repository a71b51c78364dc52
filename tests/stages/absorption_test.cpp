// Stage absorption: backend against reference from identical input.

#include <gtest/gtest.h>

#include "stage_compare.hpp"

namespace drench::test {

TEST(absorption, agrees_with_the_reference) { compare_stage({.stage = Stage::absorption, .changes = "node_liquid"}); }

}  // namespace drench::test
