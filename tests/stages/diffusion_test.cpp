// Stage diffusion: backend against reference from identical input.

#include <gtest/gtest.h>

#include "stage_compare.hpp"

namespace drench::test {

TEST(diffusion, agrees_with_the_reference) { compare_stage({.stage = Stage::diffusion, .changes = "node_liquid"}); }

TEST(diffusion, degenerate_law_agrees_with_the_reference) {
  compare_stage({.stage = Stage::diffusion,
                 .scene = with(wet_scene(), "diffusivity: 1.0e-3", "diffusivity: 1.0e-3, diffusion: degenerate"),
                 .changes = "node_liquid"});
}
}  // namespace drench::test
