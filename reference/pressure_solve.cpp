// The projected Jacobi iteration of both DFSPH solves (src/stages/divergence.hpp, pressure.hpp).

#include <algorithm>
#include <cmath>

#include "common.hpp"

namespace drench::reference {

namespace {

/// Σ_i V_i κ_i r_i: half of how fast the solve's energy falls as κ grows (docs/theory/liquid.md, Eq. 20a).
double start_work(ReferenceState& state, const std::vector<double>& kappa, const std::vector<double>& applied,
                  const std::vector<bool>& active, double dt, ClothResponse& cloth, const Residuals& residuals) {
  const PressureResponse response = pressure_response(state, applied);
  Vectors fluid;
  for (Index i = 0; i < state.s.fluid_count(); ++i)
    fluid.push_back(vec(state.s.fluid_velocity[i]) + dt * response.fluid[i]);
  respond_bodies(state, applied, dt);
  const std::vector<double> rate = density_rate(state, fluid, cloth.velocities(response.node_force));
  double work = 0;
  for (Index i = 0; i < state.s.fluid_count(); ++i)
    if (active[i])
      work +=
          fluid_volume(state, i) * kappa[i] * residuals.compression(i, rate[i] - dt * state.compliance[i] * applied[i]);
  return work;
}

/// κ := s κ with the s that leaves no work along κ.
void scale_start(ReferenceState& state, std::vector<double>& kappa, const std::vector<bool>& active, double dt,
                 ClothResponse& cloth, const Residuals& residuals) {
  const double none = start_work(state, kappa, std::vector<double>(kappa.size(), 0.0), active, dt, cloth, residuals);
  const double whole = start_work(state, kappa, kappa, active, dt, cloth, residuals);
  if (!(none - whole > 0)) return;
  const double scale = std::clamp(none / (none - whole), 0.0, 4.0);
  for (double& k : kappa) k *= scale;
}

}  // namespace

SolveResult solve_pressure(ReferenceState& state, std::vector<double>& kappa, const std::vector<bool>& active,
                           double tolerance, double dt, ClothResponse& cloth, const Residuals& residuals) {
  const auto& solver = state.model.scene.fluid.solver;
  const Index count = state.s.fluid_count();
  SolveResult result;
  if (count == 0) return result;
  for (Index i = 0; i < count; ++i) {
    if (!active[i]) kappa[i] = 0;
  }
  if (state.model.only_liquid_answers()) scale_start(state, kappa, active, dt, cloth, residuals);
  double relaxation = state.model.relaxation, theta = 1, best = 1e300, before = 1e300;
  Iterates volume(kappa), contact(std::vector<double>(count, 0.0));  // κ and λ
  while (true) {
    ++result.iterations;
    const PressureResponse response = pressure_response(state, volume.pressure, contact.pressure);
    Vectors fluid;
    for (Index i = 0; i < count; ++i) fluid.push_back(vec(state.s.fluid_velocity[i]) + dt * response.fluid[i]);
    respond_bodies(state, volume.pressure, dt);
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
    result.error = residual / count;
    result.converged = result.error <= tolerance && complementarity / count <= tolerance && cloth.converged();
    if ((result.converged && result.iterations >= solver.min_iterations) ||
        result.iterations >= solver.max_iterations) {
      kappa = volume.pressure;
      for (Index i = 0; i < count; ++i) state.s.fluid_velocity[i] = arr(fluid[i]);
      cloth.accept(state, response.node_force);
      accept_bodies(state, kappa, dt);
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
