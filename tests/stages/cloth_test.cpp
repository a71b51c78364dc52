// Stage cloth: backend against reference from identical input.

#include <gtest/gtest.h>

#include "stage_compare.hpp"

namespace drench::test {
namespace {

/// The scene with strain damping and the other method.
std::string xpbd_scene() {
  return with(with(wet_scene(), "cloth:\n", "cloth_solver: {method: xpbd}\ncloth:\n"),
              "    pin:", "    strain_damping: 0.003\n    pin:");
}

/// Onto the sphere's top at y = -0.01.
void press_on_the_sphere(const Model& m, HostState& s) {
  for (Vec3& x : s.node_position) x[1] -= 0.0095;
  for (std::size_t n = 0; n < s.node_velocity.size(); ++n)
    if (!m.mesh.pinned[n]) s.node_velocity[n] = {0.4, -0.5, 0.1};
}

}  // namespace

TEST(cloth, agrees_with_the_reference) { compare_stage({.stage = Stage::cloth, .changes = "node_velocity"}); }

TEST(cloth, in_contact_with_a_sphere_agrees_with_the_reference) {
  compare_stage({.stage = Stage::cloth, .prepare = press_on_the_sphere, .changes = "node_contact_force"});
}

TEST(cloth, by_xpbd_agrees_with_the_reference) {
  compare_stage({.stage = Stage::cloth, .scene = xpbd_scene(), .changes = "node_velocity"});
}

TEST(cloth, by_xpbd_in_contact_with_a_sphere_agrees_with_the_reference) {
  compare_stage(
      {.stage = Stage::cloth, .scene = xpbd_scene(), .prepare = press_on_the_sphere, .changes = "node_contact_force"});
}

}  // namespace drench::test
