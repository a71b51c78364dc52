// Stage time_step (src/stages/time_step.hpp).

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "common.hpp"
#include "state/keyed_motion.hpp"

namespace drench::reference {

namespace {

/// s: the period of the shortest capillary waves over 2π; infinite without tension and adhesion.
double capillary_step(const Model& model) {
  double sigma = model.scene.fluid.surface_tension;
  for (const Body& b : model.bodies) sigma = std::max(sigma, b.adhesion);
  model.for_materials([&](const ClothMaterial& c) { sigma = std::max(sigma, c.adhesion); });
  if (!model.has_moving_liquid() || sigma <= 0) return std::numeric_limits<double>::infinity();
  return std::sqrt(model.scene.fluid.density * std::pow(model.spacing, 3) / (2 * std::numbers::pi * sigma));
}

}  // namespace

void time_step(ReferenceState& state, const StepInfo& info, StepReport& report) {
  const TimeScene& time = state.model.scene.time;
  state.s.node_pin_force.assign(state.s.node_position.size(), Vec3{0, 0, 0});
  report.dt_wanted = time.step;
  if (time.mode == TimeMode::error) report.dt_wanted = std::min(time.step, 0.7 * capillary_step(state.model));
  if (time.mode != TimeMode::cfl) return;

  const FieldScene& field = state.model.scene.field;
  double fastest = 0;
  for (Index i = 0; i < state.s.fluid_count(); ++i) {
    Eigen::Vector3d a = vec(state.model.scene.gravity);
    if (field.present) {
      a -= vec(field.rate).cwiseAbs2().cwiseProduct(vec(state.s.fluid_position[i]) - vec(field.center));
    }
    fastest = std::max(fastest, vec(state.s.fluid_velocity[i]).norm() + a.norm() * time.step);
  }
  for (const Vec3& v : state.s.node_velocity) fastest = std::max(fastest, vec(v).norm());
  for (Index k = 0; k < state.s.body_count(); ++k) {
    const Body& body = state.model.bodies[k];
    if (!body.moves()) continue;
    const double turning = vec(state.s.body_angular_velocity[k]).norm() * body.reach;
    const double fall = body.dynamic ? vec(state.model.scene.gravity).norm() * time.step : 0;
    fastest = std::max(fastest, vec(state.s.body_velocity[k]).norm() + turning + fall);
  }
  fastest = std::max(fastest, fastest_by_keys(state.model, info.time, info.time + time.step));
  if (fastest > 0) report.dt_wanted = std::min(time.step, time.cfl * state.model.spacing / fastest);
  report.dt_wanted = std::min(report.dt_wanted, 0.7 * capillary_step(state.model));
  report.dt_wanted = std::max(report.dt_wanted, time.step / 1000);
}

}  // namespace drench::reference
