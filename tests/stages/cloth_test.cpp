// Stage cloth: backend against reference from identical input.

#include <gtest/gtest.h>

#include "stage_compare.hpp"

namespace drench::test {

TEST(cloth, agrees_with_the_reference) { compare_stage({.stage = Stage::cloth, .changes = "node_velocity"}); }

TEST(cloth, in_contact_with_a_sphere_agrees_with_the_reference) {
  compare_stage({.stage = Stage::cloth,
                 .prepare =
                     [](const Model& m, HostState& s) {
                       for (Vec3& x : s.node_position) x[1] -= 0.0095;  // onto the sphere's top at y = -0.01
                       for (std::size_t n = 0; n < s.node_velocity.size(); ++n)
                         if (!m.mesh.pinned[n]) s.node_velocity[n] = {0.4, -0.5, 0.1};
                     },
                 .changes = "node_contact_force"});
}

}  // namespace drench::test
