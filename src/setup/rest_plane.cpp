#include "setup/rest_plane.hpp"

#include <Eigen/Eigenvalues>

#include "base/eigen_vec.hpp"

namespace drench {

void lay_rest_planes(Model& model) {
  if (!model.has_measures()) return;
  const ClothMesh& mesh = model.mesh;
  for (ClothMaterial& cloth : model.cloths) {
    if (!cloth.porous) continue;
    double mass = 0;
    Eigen::Vector3d center = Eigen::Vector3d::Zero();
    const auto first = static_cast<std::size_t>(cloth.first_node), last = first + cloth.node_count;
    for (std::size_t n = first; n < last; ++n) {
      mass += mesh.solid_mass[n];
      center += mesh.solid_mass[n] * to_eigen(mesh.rest_position[n]);
    }
    center /= mass;
    Eigen::Matrix3d moment = Eigen::Matrix3d::Zero();
    for (std::size_t n = first; n < last; ++n) {
      const Eigen::Vector3d x = to_eigen(mesh.rest_position[n]) - center;
      moment += mesh.solid_mass[n] * x * x.transpose();
    }
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> axes(moment);  // eigenvalues in increasing order
    cloth.rest_center = to_vec3(center);
    cloth.rest_plane = {to_vec3(axes.eigenvectors().col(2)), to_vec3(axes.eigenvectors().col(1))};
  }
}

}  // namespace drench
