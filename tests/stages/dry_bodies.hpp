#pragma once
// Bodies that fall, touch and hang on hinges, without liquid.

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <numbers>
#include <string>
#include <vector>

#include "ball_mesh.hpp"
#include "base/eigen_vec.hpp"
#include "paths.hpp"
#include "stage_compare.hpp"
#include "state/rigid_contacts.hpp"

namespace drench::test {

constexpr double g = 9.81, dt = 0.002;  // m/s², s

/// The path of an OBJ file with the mesh.
inline std::string file_of(const std::string& name, const TestMesh& mesh) {
  const auto path = own_file(name);
  std::ofstream out(path);
  for (const Eigen::Vector3d& x : mesh.points) out << fmt::format("v {:.17g} {:.17g} {:.17g}\n", x[0], x[1], x[2]);
  for (const auto& t : mesh.triangles) out << fmt::format("f {} {} {}\n", t[0] + 1, t[1] + 1, t[2] + 1);
  return path.string();
}

/// An angular cup: a hole of 0.08 m that is open above, in a box.
inline TestMesh cup_mesh(double wall = 0.01) {
  const double outside = 0.04 + wall;
  TestMesh mesh = box_mesh({-outside, 0, -outside}, {outside, 0.09 + wall, outside});
  const TestMesh hole = box_mesh({-0.04, wall, -0.04}, {0.04, 0.09 + wall, 0.04});
  mesh.points.insert(mesh.points.end(), hole.points.begin(), hole.points.end());
  for (auto t : hole.triangles) mesh.triangles.push_back({t[0] + 8, t[2] + 8, t[1] + 8});
  // Their tops become a rim.
  std::erase_if(mesh.triangles,
                [](const auto& t) { return std::all_of(t.begin(), t.end(), [](int i) { return (i & 2) != 0; }); });
  const int ring[4] = {2, 3, 7, 6};
  for (int k = 0; k < 4; ++k) {
    const int a = ring[k], b = ring[(k + 1) % 4];
    mesh.triangles.push_back({a, a + 8, b});
    mesh.triangles.push_back({b, a + 8, b + 8});
  }
  return mesh;
}

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
