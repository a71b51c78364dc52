// Stage bodies (src/stages/bodies.hpp).

#include <Eigen/LU>
#include <cmath>
#include <numbers>

#include "collision.hpp"
#include "deforming_body.hpp"
#include "rigid_bodies.hpp"

namespace drench::reference {
namespace {

using Eigen::Vector3d;

/// Points of a dynamic body that can touch a solid, relative to its centre, and how far its surface is from them.
struct Feelers {
  Vectors points;
  double radius = 0;  // m
};

Feelers feelers_of(const Body& body, const Pose& pose) {
  if (body.kind == BodyScene::Kind::sphere) return {{Vector3d::Zero()}, body.radius};
  Feelers feelers;
  const Vector3d half = 0.5 * (vec(body.box.max) - vec(body.box.min));
  for (int corner = 0; corner < 8; ++corner) {
    const Vector3d sign(corner & 1 ? 1 : -1, corner & 2 ? 1 : -1, corner & 4 ? 1 : -1);
    feelers.points.push_back(pose.orientation * half.cwiseProduct(sign));
  }
  return feelers;
}

/// Bullet knows no surface that changes its shape.
void stop_at_deforming(const Body& body, const std::vector<PlacedBody>& solids, Pose& pose) {
  if (body.kind == BodyScene::Kind::mesh) return;
  const Feelers feelers = feelers_of(body, pose);
  for (int sweep = 0; sweep < 3; ++sweep) {
    for (const PlacedBody& solid : solids) {
      if (!solid.body->deforms()) continue;
      for (const Vector3d& point : feelers.points) {
        Vector3d n;
        const std::optional<double> distance = distance_to(solid, pose.position + point, n);
        if (!distance || *distance >= feelers.radius) continue;
        const Vector3d touching = pose.position + point - feelers.radius * n, arm = touching - pose.position;
        pose.position += (feelers.radius - *distance) * n;
        const double approach = (pose.velocity + pose.spin.cross(arm) - solid.velocity_at(touching)).dot(n);
        if (approach >= 0) continue;
        const Eigen::Matrix3d answer = inertia(body, pose).inverse();
        const double impulse = -approach / (1 / body.mass + arm.cross(n).dot(answer * arm.cross(n)));
        pose.velocity += impulse / body.mass * n;
        pose.spin += impulse * (answer * arm.cross(n));
      }
    }
  }
}

}  // namespace

void bodies(ReferenceState& state, const StepInfo& info, StepReport&) {
  const Model& m = state.model;
  HostState& s = state.s;
  const double time = info.time + info.dt;
  const std::vector<PlacedBody> solids = placed_bodies(state, info);
  std::vector<RigidMotion> motion;
  for (Index k = 0; k < s.body_count(); ++k) motion.push_back(motion_of(pose_of(s, k)));
  std::vector<ContactImpulse> contacts(motion.size());
  if (m.has_dynamic_body()) contacts = state.contacts->advance(motion, info.dt, time, info.correction_share);
  for (Index k = 0; k < s.body_count(); ++k) {
    const Body& body = m.bodies[k];
    if (!body.moves()) continue;
    Pose pose = pose_of(s, k);
    if (body.dynamic) {
      const auto b = static_cast<std::size_t>(k);
      const Eigen::Matrix3d before = inertia(body, pose);
      pose = contacts[b].touched ? pose_from(motion[b]) : advanced(pose, info.dt);
      pose.spin = inertia(body, pose).inverse() * before * pose.spin;
      if (m.has_deforming_body()) stop_at_deforming(body, solids, pose);
    } else {
      pose = prescribed_pose(body, time);
    }
    set_pose(s, k, pose);
  }
  for (Index b = 0; b < m.boundary.count(); ++b) {
    const Body& body = m.bodies[m.boundary.body[b]];
    if (!body.moves()) continue;
    const Pose pose = pose_of(s, m.boundary.body[b]);
    Vector3d own = vec(m.boundary.position[b]) - vec(body.center);
    if (body.slides) {
      const Vector3d middle = vec(body.middle),
                     way = middle - vec(body.center) - pose.orientation.conjugate() * (middle - pose.position);
      for (const Vec3& step : body.lattice)
        own -= std::floor(way.dot(vec(step)) / vec(step).squaredNorm() + slide_offset) * vec(step);
    }
    const Vector3d x = pose.position + pose.orientation * own;
    s.boundary_position[b] = arr(x);
    s.boundary_velocity[b] = arr(pose.velocity_at(x));
  }
  if (m.has_deforming_body()) place_shape_samples(state, time);
}

}  // namespace drench::reference
