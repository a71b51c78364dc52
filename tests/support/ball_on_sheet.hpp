#pragma once
// A dynamic ball above a sheet of cloth: a scene for the tests of what the two do to each other.

#include <fmt/format.h>

#include <string>

#include "pipeline/backend.hpp"

namespace drench::test {

struct BallOnSheet {
  double density = 100;                        // kg/m³
  std::string cloth = "pin: [{edges: true}]";  // keys of the cloth
  std::string top = "";                        // lines at the scene's top
  double step = 0.002;                         // s
};

/// A ball of radius 50 mm on a sheet of 0.4 m by 0.4 m, and a few particles that leave the domain at once.
inline std::string scene_of(const BallOnSheet& ball) {
  return fmt::format(R"(drench: 1
time: {{step: {}, end: 100}}
domain: {{min: [-1, -1, -1], max: [3, 2, 1]}}
output: {{every: 0}}
{}fluid: {{spacing: 0.02, sources: [{{block: {{min: [2, -0.99, 0], max: [2.04, -0.95, 0.04],
    velocity: [0, -20, 0]}}}}]}}
cloth:
  - mesh: {{grid: {{size: [0.4, 0.4], nodes: [21, 21]}}}}
    thickness: 0.004
    {}
bodies:
  - sphere: {{center: [0.011, 0.056, 0.023], radius: 0.05, dynamic: true, density: {}, velocity: [0, -0.5, 0]}}
)",
                     ball.step, ball.top, ball.cloth, ball.density);
}

/// Momentum of cloth, its liquid and the first body, kg m/s.
inline Vec3 momentum_with_body(const Model& m, const HostState& s) {
  Vec3 sum{};
  for (std::size_t a = 0; a < 3; ++a) {
    sum[a] = m.bodies[0].mass * s.body_velocity[0][a];
    for (std::size_t n = 0; n < s.node_velocity.size(); ++n)
      sum[a] += (m.mesh.solid_mass[n] + m.quantum * static_cast<double>(s.node_liquid[n])) * s.node_velocity[n][a];
  }
  return sum;
}

inline double cloth_mass(const Model& m) {
  double sum = 0;
  for (const double mass : m.mesh.solid_mass) sum += mass;
  return sum;
}

}  // namespace drench::test
