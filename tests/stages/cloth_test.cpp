// Stage cloth: backend against reference from identical input.

#include <gtest/gtest.h>

#include "stage_compare.hpp"

namespace drench::test {

TEST(cloth, agrees_with_the_reference) { compare_stage({.stage = Stage::cloth, .changes = "node_velocity"}); }

}  // namespace drench::test
