#pragma once
// Geometry of collisions: a moving point against a moving triangle, and points against solid bodies. Lengths in m;
// times τ are fractions of the step, 1.

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <array>
#include <memory>
#include <optional>
#include <vector>

#include "deforming_body.hpp"
#include "rigid_bodies.hpp"

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
/// coordinates ≥ −1e-6, or no farther from its outline than 1e-6 of its longest edge. At τ = 1 it also lies there if it
/// is no farther from the plane than `touch` (m).
std::optional<Hit> first_hit(const MovingTriangle& triangle, const Eigen::Vector3d& x0, const Eigen::Vector3d& x1,
                             double touch = 0);

/// A body where it is at the end of the step.
struct PlacedBody {
  const Body* body;
  Index index;
  Pose pose;
  std::shared_ptr<const DeformedSurface> surface = {};  // of one that changes its shape
  int part = 0;                                         // of Body::parts, as if each were a body of its own
  Eigen::Vector3d velocity_at(const Eigen::Vector3d& x) const {
    return surface ? surface->velocity(x) : pose.velocity_at(x);
  }
};
/// All bodies, and then the second parts of meshes.
std::vector<PlacedBody> placed_bodies(const ReferenceState& state, const StepInfo& info);

/// Distance of x to a body, and its normal; none for a mesh that is not closed.
std::optional<double> distance_to(const PlacedBody& body, const Eigen::Vector3d& x, Eigen::Vector3d& normal);
/// The same; `slope`: how fast it grows along the normal, 1 but for a mesh's interpolated distance.
std::optional<double> distance_to(const PlacedBody& body, const Eigen::Vector3d& x, Eigen::Vector3d& normal,
                                  double& slope);

struct BodyContact {
  Eigen::Vector3d normal, surface;  // surface: its velocity there, m/s
  /// v without its part into the surface.
  Eigen::Vector3d stopped(const Eigen::Vector3d& v) const {
    return v - normal * std::min(0.0, (v - surface).dot(normal));
  }
};

/// A body next to a node of the cloth: how far it is and what the node keeps from it alone, m.
struct NearBody {
  double distance = 0, slope = 1;  // slope: of the distance along the normal
  Eigen::Vector3d normal = Eigen::Vector3d::Zero();
  double kept = 0;
  bool plane = false;  // a plane stands for it in this step
};

/// How far a node stays from bodies: its thickness, or less from one that it has begun the step inside of.
struct Clearance {
  double thickness = 0, release = 0, dt = 0;  // m, m, s
  Eigen::Vector3d start{0, 0, 0};             // m
  double least = 0;                           // m: what it keeps from any body
  /// One of the bodies as the node at x sees it (docs/theory/cloth.md, (26b), (26d)); none where it has no distance.
  std::optional<NearBody> near(const PlacedBody& body, const Eigen::Vector3d& x) const;
};
Clearance clearance_of(const ReferenceState& state, const std::vector<PlacedBody>& bodies, Index n, double dt);
/// The gap (m) between two bodies that face each other at x, if it leaves cloth no room on both sides.
std::optional<double> gap_between(const PlacedBody& one, const PlacedBody& other, const Clearance& clearance,
                                  const Eigen::Vector3d& x);
/// The distance (m) that cloth at x keeps from a body, `near` to it: what it keeps from that alone, or its share of
/// such a gap.
double distance_to_keep(const std::vector<PlacedBody>& bodies, const PlacedBody& body, const NearBody& near,
                        const Clearance& clearance, const Eigen::Vector3d& x);
/// Moves x out of the bodies, in their order, to that distance where it is closer. Returns the contacts with those
/// bodies that moved it, with the surface's velocity at x as it was. Thickness 0: a particle of liquid.
std::vector<BodyContact> project_out(const std::vector<PlacedBody>& bodies, const Clearance& clearance,
                                     Eigen::Vector3d& x);

}  // namespace drench::reference
