#pragma once
// Bodies of the oracle that change their shape (docs/theory/deforming_bodies.md).

#include <Eigen/Core>
#include <optional>
#include <unordered_map>

#include "common.hpp"

namespace drench::reference {

/// Points of the mesh at a time (s), m.
Vectors shape_points(const Body& body, double time);
/// Their velocities right after it, m/s.
Vectors shape_velocities(const Body& body, double time);

/// The surface at the end of a step, and its distances.
class DeformedSurface {
 public:
  DeformedSurface(const Body& body, double time, double dt);

  /// Interpolated on the lattice; none beyond it. `slope`: how fast it grows along the normal.
  std::optional<double> distance(const Eigen::Vector3d& x, Eigen::Vector3d& normal, double& slope) const;
  /// Mean velocity over the step of the nearest point, of the triangle that the nearest lattice point has; 0 beyond the
  /// band.
  Eigen::Vector3d velocity(const Eigen::Vector3d& x) const;

 private:
  struct LatticePoint {
    double distance = 0;
    Index triangle = -1;
  };
  const LatticePoint& at(Index i, Index j, Index k) const;
  Eigen::Vector3d where(const Eigen::Vector3d& x) const { return (x - origin_) / spacing_; }

  const Body& body_;
  Vectors points_, velocities_;
  Eigen::Vector3d origin_;
  double spacing_;
  mutable std::unordered_map<std::int64_t, LatticePoint> known_;
};

/// boundary_velocity of the samples: their way over the step, divided by it.
void move_shape_samples(ReferenceState& state, const StepInfo& info);
/// Position, velocity and volume of the samples at a time, s.
void place_shape_samples(ReferenceState& state, double time);

}  // namespace drench::reference
