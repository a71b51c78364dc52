#pragma once
// Bending of a flat sheet rolled to a cylinder.

#include <Eigen/Dense>
#include <cmath>
#include <numbers>

#include "state/model.hpp"

namespace drench::test {

/// Energy of its hinges, Σ ½ c |Kᵀx|², or as a plate, J, of a sheet in the plane y = 0 rolled to `curvature` (1/m)
/// across the direction that is turned by `degrees` in its plane.
inline double rolled_energy(const ClothMesh& mesh, double curvature, double degrees) {
  const double turn = degrees * std::numbers::pi / 180;
  double energy = 0;
  for (std::size_t h = 0; h < mesh.hinge.size(); ++h) {
    Eigen::Vector3d bend = Eigen::Vector3d::Zero();
    for (std::size_t c = 0; c < 4; ++c) {
      const Vec3& x = mesh.rest_position[static_cast<std::size_t>(mesh.hinge[h][c])];
      const double across = x[0] * std::cos(turn) + x[2] * std::sin(turn);
      const double along = -x[0] * std::sin(turn) + x[2] * std::cos(turn);
      const double phi = across * curvature;
      bend += mesh.hinge_weight[h][c] * Eigen::Vector3d(std::sin(phi) / curvature, std::cos(phi) / curvature, along);
    }
    energy += 0.5 * mesh.hinge_stiffness[h] * bend.squaredNorm();
  }
  const auto rolled = [&](Index n) {
    const Vec3& x = mesh.rest_position[static_cast<std::size_t>(n)];
    const double phi = (x[0] * std::cos(turn) + x[2] * std::sin(turn)) * curvature;
    return Eigen::Vector3d(std::sin(phi) / curvature, std::cos(phi) / curvature,
                           -x[0] * std::sin(turn) + x[2] * std::cos(turn));
  };
  for (std::size_t k = 0; k < mesh.plate_pair.size(); ++k)
    energy -=
        0.5 * mesh.plate_weight[k] * (rolled(mesh.plate_pair[k][0]) - rolled(mesh.plate_pair[k][1])).squaredNorm();
  return energy;
}

}  // namespace drench::test
