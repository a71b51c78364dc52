// Stage forces: backend against reference from identical input.

#include <gtest/gtest.h>

#include "stage_compare.hpp"

namespace drench::test {

TEST(forces, agrees_with_the_reference) {
  compare_stage_with_every_kernel({.stage = Stage::forces, .changes = "fluid_velocity"});
}

}  // namespace drench::test
