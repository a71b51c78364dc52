// Stage emission: backend against reference from identical input.

#include <gtest/gtest.h>

#include "stage_compare.hpp"

namespace drench::test {

TEST(emission, agrees_with_the_reference) { compare_stage({.stage = Stage::emission, .changes = "node_liquid"}); }

TEST(emission, new_particles_agree_with_the_reference) {
  compare_stage({.stage = Stage::emission,
                 .steps_before = 2,
                 .prepare =
                     [](const Model& m, HostState& s) {
                       overfill(m, s, 8);
                       for (Vec3& x : s.fluid_position) x[1] += 0.2;  // room below the sheet
                     },
                 .changes = "fluid_id"});
}

TEST(emission, of_steep_fabric_agrees_with_the_reference) {
  // Only samples at the hem make particles.
  compare_stage({.stage = Stage::emission,
                 .scene = with(with(wet_scene(), "    thickness: 0.002\n",
                                    "    thickness: 0.04\n    place: {rotate: {axis: [1, 0, 0], degrees: 75}}\n"),
                               "hold_saturation: [{box: {min: [-0.2, -1, 0.12]",
                               "hold_saturation: [{box: {min: [-0.2, -1, 0.03]"),
                 .steps_before = 2,
                 .prepare = [](const Model& m, HostState& s) { overfill(m, s, 50); },
                 .changes = "fluid_id"});
}

}  // namespace drench::test
