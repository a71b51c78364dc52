#pragma once
// Scenes for the tests of the set-up, and what these look for in its results.

#include <algorithm>
#include <array>
#include <numeric>
#include <string>
#include <vector>

#include "base/eigen_vec.hpp"
#include "setup/build.hpp"

namespace drench::testing {

inline constexpr double d = 0.02;  // m: the spacing of wet_scene()

/// A domain for liquid, with none in it yet.
inline Scene wet_scene() {
  Scene scene;
  scene.domain = {{-1, -1, -1}, {1, 1, 1}};
  scene.fluid.present = true;
  scene.fluid.spacing = d;
  return scene;
}

/// A porous sheet of a grid.
inline Scene cloth_scene(std::array<double, 2> size = {0.5, 0.3}, std::array<int, 2> nodes = {11, 7}) {
  Scene scene;
  ClothScene cloth;
  cloth.name = "sheet";
  cloth.grid = GridScene{size, nodes};
  cloth.material.porous = true;
  scene.cloths.push_back(cloth);
  return scene;
}

inline BodyScene box_body(const Box& box, bool inside = false) {
  BodyScene body;
  body.box = box;
  body.inside = inside;
  return body;
}

inline BodyScene sphere_body(const Vec3& center, double radius) {
  BodyScene body;
  body.kind = BodyScene::Kind::sphere;
  body.center = center;
  body.radius = radius;
  return body;
}

/// What set-up says of a scene that it refuses, "" if it takes it.
inline std::string error_of(const Scene& scene) {
  try {
    build(scene);
  } catch (const SetupError& e) {
    return e.what();
  }
  return "";
}

/// Does any of the lines contain `text`?
inline bool any_has(const std::vector<std::string>& lines, const std::string& text) {
  return std::any_of(lines.begin(), lines.end(), [&](const auto& l) { return l.find(text) != std::string::npos; });
}

inline double sum(const std::vector<double>& v) { return std::accumulate(v.begin(), v.end(), 0.0); }

/// Of each point to the nearest other, m.
inline std::vector<double> nearest_distances(const std::vector<Vec3>& x) {
  std::vector<double> nearest(x.size(), 1e9);
  for (std::size_t i = 0; i < x.size(); ++i) {
    for (std::size_t j = 0; j < x.size(); ++j) {
      if (i != j) nearest[i] = std::min(nearest[i], (to_eigen(x[i]) - to_eigen(x[j])).norm());
    }
  }
  return nearest;
}

}  // namespace drench::testing
