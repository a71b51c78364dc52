#include "setup/cloth_warp.hpp"

#include <fmt/format.h>

#include <Eigen/Geometry>

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
    const auto at = [&](std::size_t c) { return to_eigen(own.points[static_cast<std::size_t>(own.triangles[t][c])]); };
    const Vector3d a = at(1) - at(0), b = at(2) - at(0), normal = a.cross(b).normalized();
    Vector3d warp = of_file ? along_v(a, b, own.texture[t]) : Vector3d(given - given.dot(normal) * normal);
    if (!(warp.norm() > (of_file ? 0 : 1e-6)))
      throw SetupError(fmt::format(
          "{}: triangle {} {}; allowed: {}", cloth_label(cloth.name), t,
          of_file ? "has no area in the file's texture" : "lies across the direction of warp",
          of_file ? "a texture that covers it, or the key warp" : "a direction that lies in no triangle's normal"));
    mesh.triangle_warp.push_back(to_vec3(warp.normalized()));
  }
}

}  // namespace drench
