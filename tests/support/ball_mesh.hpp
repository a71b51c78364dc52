#pragma once
// A ball and a box of triangles for tests, and sequences of mesh files whose points go where a function says.

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <array>
#include <filesystem>
#include <fstream>
#include <functional>
#include <map>
#include <string>
#include <vector>

#include "paths.hpp"

namespace drench::test {

struct TestMesh {
  std::vector<Eigen::Vector3d> points;
  std::vector<std::array<int, 3>> triangles;
};

/// A unit ball: an octahedron whose triangles are divided into four `levels` times, 8·4^levels of them.
inline TestMesh ball_mesh(int levels) {
  using Eigen::Vector3d;
  TestMesh mesh{{Vector3d::UnitX(), Vector3d::UnitY(), Vector3d::UnitZ(), -Vector3d::UnitX(), -Vector3d::UnitY(),
                 -Vector3d::UnitZ()},
                {{0, 1, 2}, {1, 3, 2}, {3, 4, 2}, {4, 0, 2}, {1, 0, 5}, {3, 1, 5}, {4, 3, 5}, {0, 4, 5}}};
  for (int level = 0; level < levels; ++level) {
    std::map<std::pair<int, int>, int> middles;
    const auto middle = [&](int a, int b) {
      const auto [at, fresh] = middles.try_emplace(std::minmax(a, b), static_cast<int>(mesh.points.size()));
      const Vector3d between = mesh.points[static_cast<std::size_t>(a)] + mesh.points[static_cast<std::size_t>(b)];
      if (fresh) mesh.points.push_back(between.normalized());
      return at->second;
    };
    std::vector<std::array<int, 3>> finer;
    for (const auto& [a, b, c] : mesh.triangles) {
      const int ab = middle(a, b), bc = middle(b, c), ca = middle(c, a);
      finer.insert(finer.end(), {{a, ab, ca}, {ab, b, bc}, {ca, bc, c}, {ab, bc, ca}});
    }
    mesh.triangles = std::move(finer);
  }
  return mesh;
}

/// A solid box of 12 triangles.
inline TestMesh box_mesh(const Eigen::Vector3d& low, const Eigen::Vector3d& high) {
  TestMesh mesh;
  for (int k = 0; k < 8; ++k)
    mesh.points.emplace_back((k & 1 ? high : low)[0], (k & 2 ? high : low)[1], (k & 4 ? high : low)[2]);
  mesh.triangles = {{0, 2, 1}, {1, 2, 3}, {4, 5, 6}, {5, 7, 6}, {0, 1, 4}, {1, 5, 4},
                    {2, 6, 3}, {3, 6, 7}, {0, 4, 2}, {2, 4, 6}, {1, 3, 5}, {3, 7, 5}};
  return mesh;
}

/// The text of an OBJ file with a mesh.
inline std::string obj_of(const TestMesh& mesh, double scale = 1) {
  std::string text;
  for (const Eigen::Vector3d& x : mesh.points)
    text += fmt::format("v {:.17g} {:.17g} {:.17g}\n", scale * x[0], scale * x[1], scale * x[2]);
  for (const auto& t : mesh.triangles) text += fmt::format("f {} {} {}\n", t[0] + 1, t[1] + 1, t[2] + 1);
  return text;
}

/// Files 0000.obj, … of a mesh, `count` of them; place(k, x) says where a point is in file k. Returns the pattern.
inline std::string write_shapes(const std::string& name, int count, const TestMesh& mesh,
                                const std::function<Eigen::Vector3d(int, const Eigen::Vector3d&)>& place) {
  const std::filesystem::path folder = own_file(name);
  std::filesystem::create_directories(folder);
  for (int k = 0; k < count; ++k) {
    TestMesh shape = mesh;
    for (Eigen::Vector3d& x : shape.points) x = place(k, x);
    std::ofstream(folder / fmt::format("{:04d}.obj", k)) << obj_of(shape);
  }
  return (folder / "{:04d}.obj").string();
}

}  // namespace drench::test
