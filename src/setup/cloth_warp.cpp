#include "setup/cloth_warp.hpp"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <utility>

#include "base/eigen_vec.hpp"
#include "setup/cloth_mesh.hpp"
#include "setup/setup_error.hpp"

namespace drench {
namespace {

using Eigen::Vector3d;

/// ∂x/∂v of a triangle with the edges a, b and their differences of texture coordinates: the direction in which u is
/// constant. 0 where the texture has no area.
Vector3d along_v(const Vector3d& a, const Vector3d& b, const std::array<std::array<double, 2>, 3>& uv) {
  const double au = uv[1][0] - uv[0][0], av = uv[1][1] - uv[0][1], bu = uv[2][0] - uv[0][0], bv = uv[2][1] - uv[0][1];
  const double area = au * bv - av * bu;
  if (!(std::abs(area) > 1e-12 * (au * au + av * av + bu * bu + bv * bv))) return Vector3d::Zero();
  return (au * b - bu * a) / area;
}

/// The edges of a triangle from its first corner, m.
std::pair<Vector3d, Vector3d> edges_of(const SurfaceMesh& mesh, std::size_t triangle) {
  const auto at = [&](std::size_t c) {
    return to_eigen(mesh.points[static_cast<std::size_t>(mesh.triangles[triangle][c])]);
  };
  return {at(1) - at(0), at(2) - at(0)};
}

/// The part of a unit vector that lies in the plane of two edges.
Vector3d in_plane(const Vector3d& given, const Vector3d& a, const Vector3d& b) {
  const Vector3d normal = a.cross(b).normalized();
  return given - given.dot(normal) * normal;
}

constexpr double least_in_plane = 1e-6;

bool has_directions(const MaterialScene& fabric) {
  const bool bends_apart =
      fabric.bending && (fabric.bending->warp != fabric.bending->weft || fabric.bending->warp != fabric.bending->twist);
  return fabric.membrane || bends_apart || (fabric.porous && fabric.weft_diffusivity);
}

}  // namespace

bool needs_warp(const ClothScene& cloth) { return any_fabric(cloth, has_directions); }

bool takes_warp_of_file(const ClothScene& cloth) {
  return needs_warp(cloth) && !cloth.grid && !cloth.material.has_warp;
}

bool texture_gives_warp(const SurfaceMesh& mesh) {
  for (std::size_t t = 0; t < mesh.texture.size(); ++t) {
    const auto [a, b] = edges_of(mesh, t);
    if (!(along_v(a, b, mesh.texture[t]).norm() > 0)) return false;
  }
  return !mesh.texture.empty();
}

bool lies_across(const SurfaceMesh& mesh, const Vec3& direction) {
  const Vector3d given = to_eigen(direction).normalized();
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    const auto [a, b] = edges_of(mesh, t);
    if (!(in_plane(given, a, b).norm() > least_in_plane)) return true;
  }
  return false;
}

void append_warp(ClothMesh& mesh, const SurfaceMesh& own, const ClothScene& cloth, const Patchwork& fabric,
                 const Eigen::Matrix3d& rotation) {
  if (takes_warp_of_file(cloth) && own.texture.empty())
    throw SetupError(
        fmt::format("{}: '{}' has no texture coordinates, which give the warp direction; allowed: an .obj that "
                    "has them, or the key warp",
                    cloth_label(cloth.name), cloth.file));
  mesh.triangle_warp.resize(mesh.triangle.size() - own.triangles.size(), Vec3{0, 0, 0});
  for (std::size_t t = 0; t < own.triangles.size(); ++t) {
    const MaterialScene& here = fabric(static_cast<Index>(t));
    const bool of_file = takes_warp_of_file(cloth) && !here.has_warp;
    const Vector3d given = rotation * to_eigen(here.warp).normalized();
    const auto [a, b] = edges_of(own, t);
    const Vector3d warp = of_file ? along_v(a, b, own.texture[t]) : in_plane(given, a, b);
    if (!(warp.norm() > (of_file ? 0 : least_in_plane)))
      throw SetupError(fmt::format(
          "{}: triangle {} {}; allowed: {}", cloth_label(cloth.name), t,
          of_file ? "has no area in the file's texture" : "lies across the direction of warp",
          of_file ? "a texture that covers it, or the key warp" : "a direction that lies in no triangle's normal"));
    mesh.triangle_warp.push_back(to_vec3(warp.normalized()));
  }
}

}  // namespace drench
