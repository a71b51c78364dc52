#pragma once
// Sequences of mesh files for tests: a box that moves rigidly, or not.

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <filesystem>
#include <fstream>
#include <functional>
#include <string>

#include "paths.hpp"

namespace drench::test {

/// A box of the half edges `half` (m) as an OBJ file: each corner where `place` puts it.
inline void write_box(const std::filesystem::path& path, const Eigen::Vector3d& half,
                      const std::function<Eigen::Vector3d(const Eigen::Vector3d&)>& place) {
  std::ofstream out(path);
  for (int c = 0; c < 8; ++c) {
    const Eigen::Vector3d x =
        place({c & 1 ? half[0] : -half[0], c & 2 ? half[1] : -half[1], c & 4 ? half[2] : -half[2]});
    out << fmt::format("v {:.17g} {:.17g} {:.17g}\n", x[0], x[1], x[2]);
  }
  out << "f 1 3 4\nf 1 4 2\nf 5 6 8\nf 5 8 7\nf 1 2 6\nf 1 6 5\nf 3 7 8\nf 3 8 4\nf 1 5 7\nf 1 7 3\nf 2 4 8\nf 2 8 6\n";
}

/// Files NAME_0000.obj, … of a box, `count` of them; place(k, corner) says where a corner is in file k. Returns the
/// pattern.
inline std::string write_boxes(const std::string& name, int count, const Eigen::Vector3d& half,
                               const std::function<Eigen::Vector3d(int, const Eigen::Vector3d&)>& place) {
  const std::filesystem::path folder = own_file(name);
  std::filesystem::create_directories(folder);
  for (int k = 0; k < count; ++k)
    write_box(folder / fmt::format("box_{:04d}.obj", k), half,
              [&](const Eigen::Vector3d& corner) { return place(k, corner); });
  return (folder / "box_{:04d}.obj").string();
}

}  // namespace drench::test
