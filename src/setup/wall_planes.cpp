#include "setup/wall_planes.hpp"

#include <Eigen/Geometry>
#include <cmath>

#include "base/eigen_vec.hpp"
#include "setup/body_geometry.hpp"
#include "setup/body_sampling.hpp"

namespace drench {
namespace {

using Eigen::Vector3d;

struct WallPlane {
  Vector3d normal;
  double depth;  // m
};

/// Unit normal of a triangle, 0 if it has no area.
Vector3d triangle_normal(const Body& body, Index triangle) {
  if (triangle < 0) return Vector3d::Zero();
  const auto& t = body.mesh_triangles[static_cast<std::size_t>(triangle)];
  const auto point = [&](std::size_t c) { return to_eigen(body.mesh_points[static_cast<std::size_t>(t[c])]); };
  const Vector3d across = (point(1) - point(0)).cross(point(2) - point(0));
  return across.norm() > 0 ? Vector3d(across.normalized()) : Vector3d::Zero();
}

/// The sample lies on one, two or three faces of its layer's box.
WallPlane plane_of_box(const Body& body, const Box& layer, const Vec3& x) {
  Vector3d sum = Vector3d::Zero();
  double depths = 0;
  for (std::size_t a = 0; a < 3; ++a) {
    for (const bool upper : {false, true}) {
      const double face = upper ? layer.max[a] : layer.min[a];
      if (x[a] != face) continue;
      sum[static_cast<Index>(a)] += upper != body.inside ? 1 : -1;
      depths += std::abs(face - (upper ? body.box.max : body.box.min)[a]);
    }
  }
  return {sum.normalized(), depths / sum.norm()};
}

WallPlane plane_of(const Body& body, const Body& layer, const Vec3& x) {
  if (body.kind == BodyScene::Kind::box) return plane_of_box(body, layer.box, x);
  Vec3 normal;
  const double depth = -signed_distance(body, x, normal);
  return {to_eigen(normal), depth};
}

}  // namespace

void add_wall_planes(const Body& body, double spacing, WallPressure walls, const Box& region, int layer,
                     const std::vector<Vec3>& samples, BoundarySet& set) {
  const auto add = [&](const WallPlane& plane) {
    set.wall_normal.push_back(to_vec3(plane.normal));
    set.wall_depth.push_back(plane.depth);
  };
  if (body.deforms()) {
    for (std::size_t s = 0; s < samples.size(); ++s)
      add({triangle_normal(body, body.shape.triangle[s]), body.shape.depth[s]});
  } else if (body.kind == BodyScene::Kind::mesh && body.field.empty()) {
    for (const Index triangle : triangles_of_samples(body, spacing, region)) add({triangle_normal(body, triangle), 0});
  } else {
    const Body surface = sampled_surface(body, spacing, walls, layer);
    for (const Vec3& x : samples) add(plane_of(body, surface, x));
  }
}

}  // namespace drench
