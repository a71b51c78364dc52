// Stage emission: backend against reference from identical input.

#include <gtest/gtest.h>

#include "stage_compare.hpp"

namespace drench::test {

TEST(emission, agrees_with_the_reference) { compare_stage({.stage = Stage::emission, .changes = "node_liquid"}); }

}  // namespace drench::test
