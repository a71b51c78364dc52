#pragma once
// Bodies that fall, touch and hang on hinges, without liquid.

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>
#include <vector>

#include "base/eigen_vec.hpp"
#include "stage_compare.hpp"
#include "state/rigid_contacts.hpp"

namespace drench::test {

constexpr double g = 9.81, dt = 0.002;  // m/s², s

/// Bodies, beside a speck of liquid that touches none.
inline std::string scene_of(const std::string& bodies) {
  return "drench: 1\ntime: {step: 0.002, end: 10}\ndomain: {min: [-1, -1, -1], max: [1, 2, 1]}\nfluid:\n  spacing: "
         "0.02\n"
         "  sources:\n    - block: {min: [0.9, 1.9, 0.9], max: [0.94, 1.94, 0.94]}\nbodies:\n" +
         bodies;
}

/// Bodies that fall and touch, without liquid.
struct Dry {
  explicit Dry(const std::string& bodies) : setup(setup_from(scene_of(bodies))), contacts(setup.model) {
    const HostState& s = setup.state;
    for (std::size_t b = 0; b < s.body_position.size(); ++b)
      motion.push_back({s.body_position[b], s.body_velocity[b], s.body_angular_velocity[b], s.body_orientation[b]});
  }
  void step() {
    const std::vector<RigidMotion> start = motion;
    for (std::size_t b = 0; b < motion.size(); ++b)
      if (setup.model.bodies[b].dynamic) motion[b].velocity[1] -= g * dt;
    const std::vector<RigidMotion> free = motion;
    time += dt;
    given = contacts.advance(motion, dt, time);
    for (std::size_t b = 0; b < motion.size(); ++b) {
      if (setup.model.bodies[b].dynamic && given[b].touched) continue;
      for (int a = 0; a < 3; ++a) motion[b].position[a] += dt * free[b].velocity[a];
    }
  }
  void run(double time) {
    for (double t = 0; t < time; t += dt) step();
  }
  Eigen::Vector3d at(std::size_t b) const { return to_eigen(motion[b].position); }
  Eigen::Vector3d velocity(std::size_t b) const { return to_eigen(motion[b].velocity); }
  double turned(std::size_t b) const {  // degrees
    return 360 / std::numbers::pi * std::acos(std::min(1.0, std::abs(motion[b].orientation[0])));
  }

  Setup setup;
  RigidContacts contacts;
  std::vector<RigidMotion> motion;
  std::vector<ContactImpulse> given;
  double time = 0;  // s
};

}  // namespace drench::test
