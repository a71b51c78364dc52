#include "rigid_bodies.hpp"

#include <Eigen/LU>
#include <cmath>
#include <numbers>

namespace drench::reference {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

bool is_dynamic(const ReferenceState& state, Index sample) {
  return state.model.bodies[state.model.boundary.body[sample]].dynamic;
}

Vector3d arm_of(const ReferenceState& state, Index sample) {
  return vec(state.s.boundary_position[sample]) - vec(state.s.body_position[state.model.boundary.body[sample]]);
}

/// Accelerations of the bodies' centres (m/s²) and their turning (rad/s²), six numbers a body.
std::vector<Eigen::Matrix<double, 6, 1>> accelerations(const ReferenceState& state, const Vectors& sample_force) {
  const Model& m = state.model;
  std::vector<Eigen::Matrix<double, 6, 1>> load(m.bodies.size(), Eigen::Matrix<double, 6, 1>::Zero());
  for (Index b = 0; b < m.boundary.count(); ++b) {
    load[m.boundary.body[b]].head<3>() += sample_force[b];
    load[m.boundary.body[b]].tail<3>() += arm_of(state, b).cross(sample_force[b]);
  }
  for (std::size_t k = 0; k < m.bodies.size(); ++k) {
    if (!m.bodies[k].dynamic) {
      load[k].setZero();
      continue;
    }
    const Matrix3d i = inertia(m.bodies[k], pose_of(state.s, static_cast<Index>(k)));
    load[k].head<3>() /= m.bodies[k].mass;
    load[k].tail<3>() = i.inverse() * load[k].tail<3>();
  }
  return load;
}

}  // namespace

RigidMotion motion_of(const Pose& pose) {
  const Eigen::Quaterniond& q = pose.orientation;
  return {arr(pose.position), arr(pose.velocity), arr(pose.spin), {q.w(), q.x(), q.y(), q.z()}};
}

Pose pose_from(const RigidMotion& m) {
  const Quaternion& q = m.orientation;
  return {vec(m.position), vec(m.velocity), vec(m.spin), Eigen::Quaterniond(q[0], q[1], q[2], q[3])};
}

Pose pose_of(const HostState& s, Index body) {
  const Quaternion& q = s.body_orientation[body];
  return {vec(s.body_position[body]), vec(s.body_velocity[body]), vec(s.body_angular_velocity[body]),
          Eigen::Quaterniond(q[0], q[1], q[2], q[3])};
}

void set_pose(HostState& s, Index body, const Pose& pose) {
  s.body_position[body] = arr(pose.position);
  s.body_velocity[body] = arr(pose.velocity);
  s.body_angular_velocity[body] = arr(pose.spin);
  s.body_orientation[body] = {pose.orientation.w(), pose.orientation.x(), pose.orientation.y(), pose.orientation.z()};
}

namespace {

Eigen::Quaterniond quaternion(const Quaternion& q) { return {q[0], q[1], q[2], q[3]}; }

/// Between two orientations it turns evenly about one axis.
Eigen::Quaterniond turned_by(const Body& body, double time) {
  if (time <= body.turns.front().time) return quaternion(body.turns.front().value);
  for (std::size_t k = 1; k < body.turns.size(); ++k) {
    const Key<Quaternion>&first = body.turns[k - 1], &last = body.turns[k];
    if (time >= last.time) continue;
    const Eigen::AngleAxisd turn(quaternion(last.value) * quaternion(first.value).conjugate());
    const double part = (time - first.time) / (last.time - first.time);
    return Eigen::AngleAxisd(part * turn.angle(), turn.axis()) * quaternion(first.value);
  }
  return quaternion(body.turns.back().value);
}

}  // namespace

Vector3d angular_velocity(const Eigen::Quaterniond& first, const Eigen::Quaterniond& last, double time) {
  const Eigen::AngleAxisd turn(last * first.conjugate());
  return turn.angle() / time * turn.axis();
}

Pose prescribed_pose(const Body& body, double time) {
  Pose pose;
  if (body.commanded) {
    const CommandedMotion& c = body.command;
    pose.position = vec(body.center) + vec(c.moved);
    pose.orientation = quaternion(c.orientation);
    pose.velocity = vec(c.velocity);
    pose.spin = vec(c.spin);
    pose = advanced(pose, std::min(time, c.end) - c.start);
    if (time >= c.end) pose.velocity = pose.spin = Vector3d::Zero();
    return pose;
  }
  const double angle = body.spin_rate.integral(0, time);
  pose.position = vec(body.center) + vec(body.velocity.integral(0, time)) + vec(body.path.at(time));
  pose.orientation = Eigen::AngleAxisd(std::remainder(angle, 4 * std::numbers::pi), vec(body.spin_axis));
  if (!body.turns.empty()) pose.orientation = turned_by(body, time);
  pose.velocity = vec(body.velocity.at(time)) + vec(body.path.derivative(time));
  pose.spin = body.spin_rate.at(time) * vec(body.spin_axis);
  for (std::size_t k = 1; k < body.turns.size(); ++k) {
    const Key<Quaternion>&first = body.turns[k - 1], &last = body.turns[k];
    if (time >= first.time && time < last.time)
      pose.spin = angular_velocity(quaternion(first.value), quaternion(last.value), last.time - first.time);
  }
  return pose;
}

Pose advanced(const Pose& pose, double dt) {
  Pose end = pose;
  end.position += dt * pose.velocity;
  const double angle = dt * pose.spin.norm();
  if (angle > 0) end.orientation = Eigen::AngleAxisd(angle, pose.spin.normalized()) * pose.orientation;
  end.orientation.normalize();
  return end;
}

void hold(const ReferenceState& state, const StepInfo& info, std::vector<Pose>& poses) {
  if (!state.contacts) return;
  std::vector<RigidMotion> motion;
  for (const Pose& pose : poses) motion.push_back(motion_of(pose));
  state.contacts->hold(motion, info.dt, info.time + info.dt, info.correction_share);
  for (std::size_t k = 0; k < poses.size(); ++k) {
    poses[k].velocity = vec(motion[k].velocity);
    poses[k].spin = vec(motion[k].spin);
  }
}

Matrix3d inertia(const Body& body, const Pose& pose) {
  const Quaternion& p = body.principal;
  const Matrix3d r = (pose.orientation * Eigen::Quaterniond(p[0], p[1], p[2], p[3])).toRotationMatrix();
  return r * vec(body.inertia).asDiagonal() * r.transpose();
}

void push_body(ReferenceState& state, Index body, const Six& impulse) {
  const Body& b = state.model.bodies[body];
  if (!b.dynamic) return;
  const Pose pose = pose_of(state.s, body);
  state.s.body_velocity[body] = arr(pose.velocity + impulse.head<3>() / b.mass);
  state.s.body_angular_velocity[body] = arr(pose.spin + inertia(b, pose).inverse() * impulse.tail<3>());
}

void refresh_body_samples(ReferenceState& state) {
  for (Index b = 0; b < state.model.boundary.count(); ++b) {
    if (!is_dynamic(state, b)) continue;
    const Pose pose = pose_of(state.s, state.model.boundary.body[b]);
    state.s.boundary_velocity[b] = arr(pose.velocity_at(vec(state.s.boundary_position[b])));
  }
}

void accelerate_bodies(ReferenceState& state, const Vectors& sample_force, double dt) {
  if (!state.model.has_dynamic_body()) return;
  const auto gain = accelerations(state, sample_force);
  for (Index k = 0; k < state.s.body_count(); ++k) {
    Pose pose = pose_of(state.s, k);
    pose.velocity += dt * gain[k].head<3>();
    pose.spin += dt * gain[k].tail<3>();
    set_pose(state.s, k, pose);
  }
  refresh_body_samples(state);
}

Vectors body_pressure_forces(const ReferenceState& state, const std::vector<double>& kappa) {
  const Smoothing w(state.model);
  Vectors force(state.s.boundary_position.size(), Vector3d::Zero());
  for (Index i = 0; i < state.s.fluid_count(); ++i) {
    for (const Index b : state.fluid_boundary[i]) {
      const Vector3d gradient = w.gradient(vec(state.s.fluid_position[i]) - vec(state.s.boundary_position[b]));
      force[b] += wall_share * fluid_mass(state, i) * state.s.boundary_volume[b] * kappa[i] * gradient;
    }
  }
  return force;
}

void respond_bodies(ReferenceState& state, const std::vector<double>& kappa, const StepInfo& info) {
  const double dt = info.dt;
  state.boundary_predicted.clear();
  for (const Vec3& v : state.s.boundary_velocity) state.boundary_predicted.push_back(vec(v));
  if (!state.model.has_dynamic_body()) return;
  auto gain = accelerations(state, body_pressure_forces(state, kappa));
  std::vector<Pose> poses;
  for (Index k = 0; k < state.s.body_count(); ++k) {
    Pose pose = pose_of(state.s, k);
    pose.velocity += dt * gain[k].head<3>();
    pose.spin += dt * gain[k].tail<3>();
    poses.push_back(pose);
  }
  hold(state, info, poses);
  for (Index k = 0; k < state.s.body_count(); ++k) {
    const Pose now = pose_of(state.s, k);
    gain[k] << (poses[k].velocity - now.velocity) / dt, (poses[k].spin - now.spin) / dt;
  }
  for (Index b = 0; b < state.model.boundary.count(); ++b) {
    const auto& a = gain[state.model.boundary.body[b]];
    state.boundary_predicted[b] += dt * (a.head<3>() + a.tail<3>().cross(arm_of(state, b)));
  }
}

void accept_bodies(ReferenceState& state, const std::vector<double>& kappa, double dt) {
  if (state.model.has_dynamic_body()) accelerate_bodies(state, body_pressure_forces(state, kappa), dt);
}

namespace {

/// Of each body's samples around particle i: Σ V |∇W| r, and of all of them.
std::vector<double> shares_of_bodies(const ReferenceState& state, Index i, double& all) {
  const Smoothing w(state.model);
  std::vector<double> share(state.model.bodies.size(), 0.0);
  all = 0;
  for (const Index b : state.fluid_boundary[i]) {
    const Vector3d r = vec(state.s.fluid_position[i]) - vec(state.s.boundary_position[b]);
    const double weight = -state.s.boundary_volume[b] * w.gradient(r).dot(r);
    share[state.model.boundary.body[b]] += weight;
    all += weight;
  }
  return share;
}

}  // namespace

void push_bodies_back(ReferenceState& state, const Vectors& change) {
  const Model& m = state.model;
  if (state.wall_gain.empty() || !m.has_dynamic_body()) return;
  std::vector<Six> impulse(m.bodies.size(), Six::Zero());
  for (Index i = 0; i < state.s.fluid_count(); ++i) {
    double all = 0;
    const std::vector<double> share = shares_of_bodies(state, i, all);
    if (!(all > 0)) continue;
    const Vector3d given = fluid_mass(state, i) * (change[i] - state.wall_gain[i].inverse() * change[i]);
    for (std::size_t k = 0; k < m.bodies.size(); ++k) {
      const Vector3d arm = vec(state.s.fluid_position[i]) - vec(state.s.body_position[k]);
      impulse[k].head<3>() -= share[k] / all * given;
      impulse[k].tail<3>() -= share[k] / all * arm.cross(given);
    }
  }
  for (Index k = 0; k < state.s.body_count(); ++k) push_body(state, k, impulse[static_cast<std::size_t>(k)]);
  refresh_body_samples(state);
}

void add_body_rows(ReferenceState& state) {
  const Model& m = state.model;
  if (!m.has_dynamic_body()) return;
  const Smoothing w(m);
  // Absolute forces and torques that unit κ of all particles would make.
  std::vector<double> push(m.bodies.size(), 0.0), turn(m.bodies.size(), 0.0);
  const auto gradient_at = [&](Index i, Index b) {
    return w.gradient(vec(state.s.fluid_position[i]) - vec(state.s.boundary_position[b]));
  };
  for (Index i = 0; i < state.s.fluid_count(); ++i) {
    for (const Index b : state.fluid_boundary[i]) {
      const double load = fluid_mass(state, i) * state.s.boundary_volume[b];
      push[m.boundary.body[b]] += load * gradient_at(i, b).norm();
      turn[m.boundary.body[b]] += load * arm_of(state, b).cross(gradient_at(i, b)).norm();
    }
  }
  for (Index i = 0; i < state.s.fluid_count(); ++i) {
    if (state.alpha[i] == 0) continue;
    double row = 0;
    for (const Index b : state.fluid_boundary[i]) {
      if (!is_dynamic(state, b)) continue;
      const Index k = m.boundary.body[b];
      row += state.s.boundary_volume[b] *
             (gradient_at(i, b).norm() * push[k] / m.bodies[k].mass +
              arm_of(state, b).cross(gradient_at(i, b)).norm() * turn[k] / vec(m.bodies[k].inertia).minCoeff());
    }
    state.alpha[i] = 1 / (1 / state.alpha[i] + state.model.row_share() * wall_share * wall_share * row);
  }
}

}  // namespace drench::reference
