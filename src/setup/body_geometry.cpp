#include "setup/body_geometry.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "base/eigen_vec.hpp"
#include "setup/distance_field.hpp"
#include "setup/file_place.hpp"
#include "setup/mesh_io.hpp"
#include "setup/mesh_sequence.hpp"
#include "setup/setup_error.hpp"
#include "state/keyed_motion.hpp"

namespace drench {
namespace {

Vec3 unit(const Vec3& v, const std::string& what) {
  const double length = to_eigen(v).norm();
  if (!(length > 0) || !std::isfinite(length)) throw SetupError(what + " must not be zero");
  return to_vec3(to_eigen(v) / length);
}

/// Distance to a solid box, and its gradient.
double box_distance(const Box& box, const Vec3& x, Eigen::Vector3d& normal) {
  const Eigen::Vector3d lo = to_eigen(box.min), hi = to_eigen(box.max);
  const Eigen::Vector3d local = to_eigen(x) - 0.5 * (lo + hi);
  const Eigen::Vector3d beyond = local.cwiseAbs() - 0.5 * (hi - lo);
  int axis = 0;
  if (beyond.maxCoeff(&axis) > 0) {
    const Eigen::Vector3d out = beyond.cwiseMax(0.0);
    const double distance = out.norm();
    normal = out / distance;
    for (int a = 0; a < 3; ++a) normal[a] = std::copysign(normal[a], local[a]);
    return distance;
  }
  normal = Eigen::Vector3d::Zero();
  normal[axis] = std::copysign(1.0, local[axis]);
  return beyond[axis];
}

}  // namespace

double signed_distance(const Body& body, const Vec3& x, Vec3& normal) {
  Eigen::Vector3d n = Eigen::Vector3d::Zero();
  double distance = 0;
  switch (body.kind) {
    case BodyScene::Kind::box:
      distance = box_distance(body.box, x, n);
      if (body.inside) {
        distance = -distance;
        n = -n;
      }
      break;
    case BodyScene::Kind::sphere: {
      n = to_eigen(x) - to_eigen(body.center);
      const double r = n.norm();
      n = r > 0 ? Eigen::Vector3d(n / r) : Eigen::Vector3d::UnitY();
      distance = r - body.radius;
      break;
    }
    case BodyScene::Kind::plane:
      n = to_eigen(body.normal);
      distance = n.dot(to_eigen(x) - to_eigen(body.point));
      break;
    case BodyScene::Kind::mesh:
      return field_distance(body.field, x, normal);
  }
  normal = to_vec3(n);
  return distance;
}

namespace {

/// Mass and principal moments of inertia of a homogeneous sphere or box.
void weigh(Body& body, double density) {
  if (body.kind == BodyScene::Kind::sphere) {
    body.mass = density * 4 / 3 * std::numbers::pi * std::pow(body.radius, 3);
    body.inertia.fill(0.4 * body.mass * body.radius * body.radius);
    return;
  }
  const Eigen::Vector3d size = to_eigen(body.box.max) - to_eigen(body.box.min);
  body.mass = density * size.prod();
  for (int a = 0; a < 3; ++a) body.inertia[a] = body.mass / 12 * (size.squaredNorm() - size[a] * size[a]);
}

/// The value without keys if it is 0 at each of them, so that a body has keys only if it moves.
template <class T>
Keyed<T> plain_if_zero(const Keyed<T>& value) {
  return value.is_zero() ? Keyed<T>() : value;
}

}  // namespace

Body make_body(const BodyScene& scene, const std::string& scene_path, const std::string& name) {
  Body body;
  body.kind = scene.kind;
  body.box = scene.box;
  body.inside = scene.inside;
  body.center = scene.center;
  body.radius = scene.radius;
  body.point = scene.point;
  body.adhesion = scene.adhesion;
  body.slip = scene.slip;
  switch (scene.kind) {
    case BodyScene::Kind::box:
      for (int a = 0; a < 3; ++a) {
        if (!(scene.box.max[a] > scene.box.min[a]))
          throw SetupError(name + ": max must be greater than min on each axis");
        body.center[a] = 0.5 * (scene.box.min[a] + scene.box.max[a]);
      }
      body.reach = 0.5 * (to_eigen(scene.box.max) - to_eigen(scene.box.min)).norm();
      break;
    case BodyScene::Kind::sphere:
      if (!(scene.radius > 0)) throw SetupError(name + ": the radius must be positive");
      body.reach = scene.radius;
      break;
    case BodyScene::Kind::plane:
      body.normal = unit(scene.normal, name + ": the normal");
      body.center = scene.point;  // its reach depends on the domain
      break;
    case BodyScene::Kind::mesh: {
      SurfaceMesh mesh = read_mesh(scene.file, scene_path);
      file_place(scene)(mesh.points);
      Eigen::AlignedBox3d bounds;
      for (const Vec3& x : mesh.points) bounds.extend(to_eigen(x));
      check_mesh(mesh, name + " (" + scene.file + ")", body_min_area_ratio);
      body.center = to_vec3(bounds.center());
      for (const Vec3& x : mesh.points) body.reach = std::max(body.reach, (to_eigen(x) - bounds.center()).norm());
      body.mesh_points = std::move(mesh.points);
      body.mesh_triangles = std::move(mesh.triangles);
      break;
    }
  }
  body.velocity = plain_if_zero(scene.velocity);
  body.path = plain_if_zero(scene.offset);
  if (!scene.spin.degrees_per_second.is_zero()) {
    body.spin_axis = unit(scene.spin.axis, name + ": the axis of spin");
    body.spin_rate = scene.spin.degrees_per_second.scaled(std::numbers::pi / 180);
  }
  if (!scene.sequence.files.empty()) follow_sequence(body, scene, scene_path, name);
  body.dynamic = scene.dynamic;
  if (scene.dynamic) weigh(body, scene.density);
  return body;
}

Vec3 body_velocity(const Body& body, const Vec3& x) {
  const Eigen::Vector3d arm = to_eigen(x) - to_eigen(body.center);
  return to_vec3(to_eigen(velocity_at(body, 0)) + to_eigen(spin_between(body, 0, 0)).cross(arm));
}

void start_bodies(const Model& model, HostState& state) {
  state.body_position.clear();
  state.body_velocity.clear();
  state.body_angular_velocity.clear();
  for (const Body& body : model.bodies) {
    state.body_position.push_back(body.center);
    state.body_velocity.push_back(velocity_at(body, 0));
    state.body_angular_velocity.push_back(spin_between(body, 0, 0));
  }
  state.body_orientation.assign(model.bodies.size(), Quaternion{1, 0, 0, 0});
}

Vec3 placed_point(const Body& body, const HostState& state, Index index, const Vec3& x) {
  const auto& q = state.body_orientation[static_cast<std::size_t>(index)];
  const Eigen::Vector3d arm = Eigen::Quaterniond(q[0], q[1], q[2], q[3]) * (to_eigen(x) - to_eigen(body.center));
  return to_vec3(to_eigen(state.body_position[static_cast<std::size_t>(index)]) + arm);
}

}  // namespace drench
