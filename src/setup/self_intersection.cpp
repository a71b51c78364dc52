#include "setup/self_intersection.hpp"

#include <fmt/format.h>

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "setup/point_grid.hpp"
#include "setup/setup_error.hpp"

namespace drench {
namespace {

using Eigen::Vector3d;

Vector3d place_of(const Model& m, Index node) {
  const Vec3& x = m.mesh.rest_position[static_cast<std::size_t>(node)];
  return {x[0], x[1], x[2]};
}

const ClothMaterial& cloth_of(const Model& m, Index node) {
  return m.cloths[static_cast<std::size_t>(m.mesh.node_cloth[static_cast<std::size_t>(node)])];
}

/// Six times the signed volume of a tetrahedron, m³.
double volume(const Vector3d& a, const Vector3d& b, const Vector3d& c, const Vector3d& d) {
  return (b - a).cross(c - a).dot(d - a);
}

/// Volumes below `rounding` (m³) have no sign: a flat sheet does not intersect itself.
bool passes_through(const Vector3d& p, const Vector3d& q, const std::array<Vector3d, 3>& t, double rounding) {
  const double from = volume(t[0], t[1], t[2], p), to = volume(t[0], t[1], t[2], q);
  if (std::min(std::abs(from), std::abs(to)) < rounding || (from > 0) == (to > 0)) return false;
  const bool first = volume(p, q, t[0], t[1]) > 0;
  return first == (volume(p, q, t[1], t[2]) > 0) && first == (volume(p, q, t[2], t[0]) > 0);
}

void refuse_thick_cloth(const Model& m) {
  for (const auto& t : m.mesh.triangle) {
    const ClothMaterial& cloth = cloth_of(m, t[0]);
    if (!cloth.self_collision) continue;
    const double thickness = std::max(
        {m.material_of_node(t[0]).thickness, m.material_of_node(t[1]).thickness, m.material_of_node(t[2]).thickness});
    const Vector3d u = place_of(m, t[1]) - place_of(m, t[0]), v = place_of(m, t[2]) - place_of(m, t[0]);
    const double longest = std::max({u.norm(), v.norm(), (v - u).norm()});
    const double height = u.cross(v).norm() / longest;
    if (thickness > 0.5 * height)
      throw SetupError(
          fmt::format("cloth {}: self_collision keeps layers {:.4g} m apart, more than half the height of the triangle "
                      "at ({:.4g}, "
                      "{:.4g}, {:.4g}), which is {:.4g} m high; use a smaller thickness or a coarser mesh",
                      cloth.name, thickness, place_of(m, t[0])[0], place_of(m, t[0])[1], place_of(m, t[0])[2], height),
          fmt::format("cloth.{}.thickness", &cloth - m.cloths.data()));
  }
}

}  // namespace

void refuse_self_intersections(const Model& m) {
  if (!m.has_self_collision()) return;
  refuse_thick_cloth(m);
  const double longest = *std::max_element(m.mesh.edge_length.begin(), m.mesh.edge_length.end());
  const double rounding = 1e-12 * longest * longest * longest;
  PointGrid middles(longest);
  for (const auto& e : m.mesh.edge) {
    const Vector3d middle = 0.5 * (place_of(m, e[0]) + place_of(m, e[1]));
    middles.add({middle[0], middle[1], middle[2]});
  }
  for (const auto& t : m.mesh.triangle) {
    if (!cloth_of(m, t[0]).self_collision) continue;
    const std::array<Vector3d, 3> corner{place_of(m, t[0]), place_of(m, t[1]), place_of(m, t[2])};
    const Vector3d lo = corner[0].cwiseMin(corner[1]).cwiseMin(corner[2]).array() - 0.5 * longest;
    const Vector3d hi = corner[0].cwiseMax(corner[1]).cwiseMax(corner[2]).array() + 0.5 * longest;
    middles.for_box({lo[0], lo[1], lo[2]}, {hi[0], hi[1], hi[2]}, [&](Index k) {
      const auto& e = m.mesh.edge[static_cast<std::size_t>(k)];
      if (!cloth_of(m, e[0]).self_collision) return;
      if (std::count(t.begin(), t.end(), e[0]) + std::count(t.begin(), t.end(), e[1]) > 0) return;
      if (!passes_through(place_of(m, e[0]), place_of(m, e[1]), corner, rounding)) return;
      const std::string &one = cloth_of(m, e[0]).name, &other = cloth_of(m, t[0]).name;
      throw SetupError(
          fmt::format(
              "cloth {} intersects {} near ({:.4g}, {:.4g}, {:.4g}): with self_collision the start must be free of "
              "intersections",
              one, one == other ? "itself" : "cloth " + other, corner[0][0], corner[0][1], corner[0][2]),
          fmt::format("cloth.{}", &cloth_of(m, e[0]) - m.cloths.data()));
    });
  }
}

}  // namespace drench
