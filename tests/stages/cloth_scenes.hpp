#pragma once
// What several tests of stage cloth share.

#include <string>

#include "stage_compare.hpp"

namespace drench::test {

/// With a membrane that softens where it is wet, and as a plate where the method has that.
inline std::string woven(const std::string& scene, bool plate = true) {
  const std::string bending = plate ? "\n    bending: {warp: 2.0e-4, weft: 5.0e-5, twist: 1.0e-4}" : "";
  return with(
      scene, "thickness: 0.002",
      "thickness: 0.002\n    membrane: {warp: 800, weft: 300, shear: 60, wet: 0.5}\n    warp: [1, 0.2, 0.4]" + bending);
}

/// Onto the sphere's top at y = -0.01.
inline void press_on_the_sphere(const Model& m, HostState& s) {
  for (Vec3& x : s.node_position) x[1] -= 0.0095;
  for (std::size_t n = 0; n < s.node_velocity.size(); ++n)
    if (!m.mesh.pinned[n]) s.node_velocity[n] = {0.4, -0.5, 0.1};
}

}  // namespace drench::test
