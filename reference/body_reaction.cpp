#include "body_reaction.hpp"

#include <Eigen/LU>
#include <algorithm>

namespace drench::reference {
namespace {

using Eigen::Vector3d;

constexpr int most_solves = 12;
constexpr double allowed_part = 0.001;  // of the thinnest cloth's thickness

Six six(const Vector3d& a, const Vector3d& b) {
  Six both;
  both << a, b;
  return both;
}

void set_velocity(ReferenceState& state, Index body, const Six& velocity) {
  state.s.body_velocity[body] = arr(velocity.head<3>());
  state.s.body_angular_velocity[body] = arr(velocity.tail<3>());
}

}  // namespace

BodyReaction::BodyReaction(ReferenceState& state, const StepInfo& info) : state_(state), dt_(info.dt) {
  if (!state.model.cloth_pushes_bodies()) return;
  for (Index k = 0; k < state.s.body_count(); ++k) {
    const Pose pose = pose_of(state.s, k);
    tried_.push_back({pose, six(pose.velocity, pose.spin), Six::Zero()});
  }
  state.model.for_materials([&](const ClothMaterial& c) { allowed_ = std::min(allowed_, allowed_part * c.thickness); });
  const std::vector<Six> last = last_impulses(info);
  for (Index k = 0; k < state.s.body_count(); ++k) {
    push_body(state, k, last[k]);
    const Pose pose = pose_of(state.s, k);
    tried_[k].velocity = six(pose.velocity, pose.spin);
  }
}

/// Of the forces of the last step, each on the last body that the node is next to.
std::vector<Six> BodyReaction::last_impulses(const StepInfo& info) const {
  const std::vector<PlacedBody> bodies = placed_bodies(state_, info);
  std::vector<Six> sum(state_.model.bodies.size(), Six::Zero());
  for (Index n = 0; n < state_.s.node_count(); ++n) {
    const Vector3d force = vec(state_.s.node_contact_force[n]) + vec(state_.s.node_friction_force[n]),
                   x = vec(state_.s.node_position[n]);
    if (force.isZero(0)) continue;
    std::size_t touched = bodies.size();
    for (std::size_t b = 0; b < bodies.size(); ++b) {
      Vector3d normal;
      const std::optional<double> distance = distance_to(bodies[b], x, normal);
      if (distance && *distance < 2 * state_.model.material_of_node(n).thickness) touched = b;
    }
    if (touched == bodies.size()) continue;
    const Vector3d push = -dt_ * force;
    sum[bodies[touched].index] += six(push, (x - bodies[touched].pose.position).cross(push));
  }
  return sum;
}

std::vector<Six> BodyReaction::impulses(const ClothProblem& problem, const Vectors& x) const {
  std::vector<Six> sum(state_.model.bodies.size(), Six::Zero());
  const Vectors r = problem.residual(x);
  for (Index n = 0; n < state_.s.node_count(); ++n) {
    if (!problem.is_free(n)) continue;
    const auto add = [&](std::size_t b, const Vector3d& force) {
      sum[problem.bodies[b].index] += dt_ * six(force, (x[n] - problem.bodies[b].pose.position).cross(force));
    };
    Vector3d left = r[n];
    const NodeContact touched = problem.contact(n, x[n], left, 1, add);
    if (!(touched.press > 0)) continue;
    const Vector3d friction = left - problem.unbalanced(n, x[n], r[n]);
    left = r[n];
    problem.contact(n, x[n], left, 1,
                    [&](std::size_t b, const Vector3d& pressed) { add(b, pressed.norm() / touched.press * friction); });
  }
  return sum;
}

Six BodyReaction::next(Index body, const Six& found) {
  Tried& t = tried_[body];
  Eigen::Matrix<double, 6, 6> mass = Eigen::Matrix<double, 6, 6>::Zero();
  mass.topLeftCorner<3, 3>().diagonal().setConstant(state_.model.bodies[body].mass);
  mass.bottomRightCorner<3, 3>() = inertia(state_.model.bodies[body], t.free);
  const Six now = found - t.velocity, change = now - t.residual;
  const double square = change.dot(mass * change);
  if (t.times++ > 0 && square > 0)
    t.factor = std::clamp(-t.factor * t.residual.dot(mass * change) / square, 0.001, 1.0);
  t.residual = now;
  return t.velocity + t.factor * now;
}

bool BodyReaction::moves_on(const ClothProblem& problem, const Vectors& x) {
  if (tried_.empty()) return false;
  const std::vector<Six> impulse = impulses(problem, x);
  disagreement_ = 0;
  std::vector<Six> found;
  for (Index b = 0; b < state_.s.body_count(); ++b) {
    set_velocity(state_, b, six(tried_[b].free.velocity, tried_[b].free.spin));
    push_body(state_, b, impulse[b]);
    const Pose pose = pose_of(state_.s, b);
    found.push_back(six(pose.velocity, pose.spin));
    const Six apart = found[b] - tried_[b].velocity;
    if (state_.model.bodies[b].dynamic)
      disagreement_ =
          std::max(disagreement_,
                   dt_ * (apart.head<3>().norm() + state_.model.bodies[b].reach * apart.tail<3>().norm()) / allowed_);
  }
  const bool again = disagreement_ > 1 && ++solves_ < most_solves;
  for (Index b = 0; b < state_.s.body_count() && again; ++b) {
    if (state_.model.bodies[b].dynamic) tried_[b].velocity = next(b, found[b]);
    set_velocity(state_, b, tried_[b].velocity);
  }
  if (!again) refresh_body_samples(state_);
  return again;
}

}  // namespace drench::reference
