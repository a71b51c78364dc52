#pragma once
// Geometry of collisions: a moving point against a moving triangle, and points against solid bodies. Lengths in m;
// times τ are fractions of the step, 1.

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <array>
#include <optional>
#include <vector>

#include "state/model.hpp"

namespace drench::reference {

using Triangle = std::array<Eigen::Vector3d, 3>;

/// A triangle whose corners move linearly from `start` (τ = 0) to `end` (τ = 1).
struct MovingTriangle {
  Triangle start, end;
  Triangle at(double tau) const;
};

struct Hit {
  double tau = 0;
  Eigen::Vector3d weight = Eigen::Vector3d::Zero();  // barycentric coordinates, Σ = 1
};

/// Unit normal by the corners' order; 0 for a triangle without area.
Eigen::Vector3d unit_normal(const Triangle& t);
/// Barycentric coordinates of x's foot point in the triangle's plane; none for a triangle without area.
std::optional<Eigen::Vector3d> barycentric(const Triangle& t, const Eigen::Vector3d& x);
Eigen::Vector3d interpolate(const Triangle& t, const Eigen::Vector3d& weight);

/// The real roots of c0 + c1 τ + c2 τ² in (0, 1), ascending; also for c2 = 0.
std::vector<double> quadratic_roots(double c0, double c1, double c2);

/// The first time in [0, 1] at which the point, moving linearly from x0 to x1, lies in the triangle: barycentric
/// coordinates ≥ −1e-6.
std::optional<Hit> first_hit(const MovingTriangle& triangle, const Eigen::Vector3d& x0, const Eigen::Vector3d& x1);

/// Distance of x to a body, and its normal; none for a mesh, which has no analytic distance.
std::optional<double> distance_to(const Body& body, const Eigen::Vector3d& x, Eigen::Vector3d& normal);

/// Moves x out of the bodies, in their order, to the distance `clearance` where it is closer. Returns the normals of
/// those bodies that moved it.
std::vector<Eigen::Vector3d> project_out(const std::vector<Body>& bodies, double clearance, Eigen::Vector3d& x);

}  // namespace drench::reference
