// The projected Jacobi iteration of both DFSPH solves (src/stages/divergence.hpp, pressure.hpp).

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "rigid_bodies.hpp"

namespace drench::reference {

namespace {

Vectors times(double factor, const Vectors& values) {
  Vectors scaled;
  for (const Eigen::Vector3d& a : values) scaled.push_back(factor * a);
  return scaled;
}

/// s of docs/theory/liquid.md, Eq. 20a; `change` is what κ does to the liquid's velocities.
double start_scale(const ReferenceState& state, const std::vector<double>& kappa, const std::vector<bool>& active,
                   const Vectors& change, const std::vector<double>& rate, double dt, const Residuals& residuals) {
  double work = 0, energy = 0;
  for (Index i = 0; i < state.s.fluid_count(); ++i) {
    const double volume = fluid_volume(state, i), yielded = dt * state.compliance[i] * kappa[i];
    if (active[i]) work += volume * kappa[i] * residuals.compression(i, rate[i] - yielded);
    const Eigen::Vector3d force = state.wall_gain.empty() ? change[i] : state.wall_gain[i].inverse() * change[i];
    energy += volume * (change[i].dot(force) + dt * yielded * kappa[i]);
  }
  return energy > 0 ? std::clamp(1 + work / energy, 0.0, 4.0) : 1;
}

}  // namespace

SolveResult solve_pressure(ReferenceState& state, std::vector<double>& kappa, const std::vector<bool>& active,
                           double tolerance, const StepInfo& info, ClothResponse& cloth, const Residuals& residuals,
                           double last_start) {
  const double dt = info.dt;
  const auto& solver = state.model.scene.fluid.solver;
  const Index count = state.s.fluid_count();
  SolveResult result;
  if (count == 0) return result;
  for (Index i = 0; i < count; ++i) {
    if (!active[i]) kappa[i] = 0;
  }
  bool judged = false;
  double relaxation = state.model.relaxation, theta = 1, best = 1e300, before = 1e300;
  Vectors start;  // what the first κ does to the liquid's velocities
  Iterates volume(kappa), contact(std::vector<double>(count, 0.0));  // κ and λ
  while (true) {
    ++result.iterations;
    const PressureResponse response = pressure_response(state, volume.pressure, contact.pressure);
    Vectors fluid;
    for (Index i = 0; i < count; ++i) fluid.push_back(vec(state.s.fluid_velocity[i]) + dt * response.fluid[i]);
    if (!judged) push_bodies_back(state, start = times(dt, response.fluid));
    respond_bodies(state, volume.pressure, info);
    const Vectors nodes = cloth.velocities(response.node_force);
    const std::vector<double> rate = density_rate(state, fluid, nodes);
    const double factor = relaxation / (dt * dt);
    volume.begin();
    contact.begin();
    for (Index i = 0; i < count; ++i) {
      if (!active[i]) continue;
      const double yielded = dt * state.compliance[i] * volume.pressure[i], alpha = state.alpha[i];
      volume.update(i, residuals.compression(i, rate[i] - yielded), factor * alpha, alpha);
    }
    if (residuals.approach) {
      const std::vector<double> approach = approach_rate(state, fluid, nodes);
      for (Index i = 0; i < count; ++i) {
        const double alpha = state.contact_alpha[i];
        if (!(alpha > 0)) continue;
        const double yielded = dt * state.contact_compliance[i] * contact.pressure[i];
        contact.update(i, residuals.approach(i, approach[i] - yielded), factor * alpha, alpha);
      }
    }
    const double residual = volume.residual_sum + contact.residual_sum,
                 complementarity = volume.complementarity + contact.complementarity;
    if (!judged) {
      judged = true;
      result.start = (residual + complementarity) / count / tolerance;
      if (state.model.scales_start(last_start)) {
        const Vectors change = times(dt, response.fluid);
        const double scale = start_scale(state, volume.pressure, active, change, rate, dt, residuals);
        for (double& k : volume.pressure) k *= scale;
        volume.last = volume.pressure;
        result.iterations = 0;
        continue;
      }
    }
    result.error = residual / count;
    const bool liquid_converged = result.error <= tolerance && complementarity / count <= tolerance;
    result.converged = liquid_converged && cloth.converged();
    if ((result.converged && result.iterations >= solver.min_iterations) ||
        result.iterations >= solver.max_iterations ||
        (liquid_converged && result.iterations >= solver.min_iterations && cloth.stalls())) {
      kappa = volume.pressure;
      for (Index i = 0; i < count; ++i) state.s.fluid_velocity[i] = arr(fluid[i]);
      cloth.accept(state, response.node_force);
      accept_bodies(state, kappa, dt);
      Vectors more = times(dt, response.fluid);  // than at the start
      for (Index i = 0; i < count; ++i) more[i] -= start[i];
      push_bodies_back(state, more);
      return result;
    }
    const double size = (residual + complementarity) / count;
    if (size > 4 * best) relaxation /= 2;
    if (volume.restart + contact.restart > 0 || size > before) theta = 1;
    best = size > 4 * best ? size : std::min(best, size);
    before = size;
    const double next_theta = (1 + std::sqrt(1 + 4 * theta * theta)) / 2, momentum = (theta - 1) / next_theta;
    volume.extrapolate(momentum);
    contact.extrapolate(momentum);
    theta = next_theta;
  }
}

}  // namespace drench::reference
