#include "setup/rest_plane.hpp"

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>

#include "base/eigen_vec.hpp"
#include "setup/surface_mesh.hpp"

namespace drench {
namespace {

using Eigen::Vector3d;

/// Σ area · warp of a cloth's triangles; a grid's z where they have none, 0 where nothing tells.
Vector3d mean_warp(const Model& model, const ClothMaterial& cloth, const ClothScene& scene) {
  const ClothMesh& mesh = model.mesh;
  Vector3d sum = Vector3d::Zero();
  const auto first = static_cast<std::size_t>(cloth.first_triangle), last = first + cloth.triangle_count;
  for (std::size_t t = first; t < last && !mesh.triangle_warp.empty(); ++t) {
    const auto at = [&](std::size_t c) { return mesh.rest_position[static_cast<std::size_t>(mesh.triangle[t][c])]; };
    sum += triangle_area(at(0), at(1), at(2)) * to_eigen(mesh.triangle_warp[t]);
  }
  if (sum.norm() > 0 || !scene.grid) return sum;
  const auto node = static_cast<std::size_t>(cloth.first_node), next = node + scene.grid->nodes[0];
  return to_eigen(mesh.rest_position[next]) - to_eigen(mesh.rest_position[node]);
}

/// The plane of a cloth with the moment Σ m x xᵀ about its centre: its two longest axes.
void lay_rest_plane(ClothMaterial& cloth, const Eigen::Matrix3d& moment, const Vector3d& warp) {
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> axes(moment);  // eigenvalues in increasing order
  cloth.rest_plane = {to_vec3(axes.eigenvectors().col(2)), to_vec3(axes.eigenvectors().col(1))};
  const Vector3d normal = axes.eigenvectors().col(0);
  const Vector3d along = warp - warp.dot(normal) * normal;
  if (!(along.norm() > 1e-3 * warp.norm())) return;
  cloth.rest_plane = {to_vec3(along.normalized()), to_vec3(normal.cross(along).normalized())};
}

}  // namespace

void lay_rest_planes(Model& model) {
  if (!model.has_measures() && !model.has_fabric()) return;
  const ClothMesh& mesh = model.mesh;
  for (std::size_t k = 0; k < model.cloths.size(); ++k) {
    ClothMaterial& cloth = model.cloths[k];
    if (!cloth.porous) continue;
    double mass = 0;
    Vector3d center = Vector3d::Zero();
    const auto first = static_cast<std::size_t>(cloth.first_node), last = first + cloth.node_count;
    for (std::size_t n = first; n < last; ++n) {
      mass += mesh.solid_mass[n];
      center += mesh.solid_mass[n] * to_eigen(mesh.rest_position[n]);
    }
    center /= mass;
    Eigen::Matrix3d moment = Eigen::Matrix3d::Zero();
    for (std::size_t n = first; n < last; ++n) {
      const Vector3d x = to_eigen(mesh.rest_position[n]) - center;
      moment += mesh.solid_mass[n] * x * x.transpose();
    }
    cloth.rest_center = to_vec3(center);
    lay_rest_plane(cloth, moment,
                   model.has_fabric() ? mean_warp(model, cloth, model.scene.cloths[k]) : Vector3d::Zero());
  }
}

std::vector<double> places_in_rest_planes(const Model& model) {
  const ClothMesh& mesh = model.mesh;
  std::vector<double> places;
  for (std::size_t n = 0; n < mesh.rest_position.size(); ++n) {
    const ClothMaterial& material = model.cloths[static_cast<std::size_t>(mesh.node_cloth[n])];
    for (const Vec3& axis : material.rest_plane) {
      double sum = 0;
      for (std::size_t a = 0; a < 3; ++a) sum += axis[a] * (mesh.rest_position[n][a] - material.rest_center[a]);
      places.push_back(sum);
    }
  }
  return places;
}

}  // namespace drench
