// Stage pressure (src/stages/pressure.hpp).

#include "stages/pressure.hpp"

#include <algorithm>
#include <memory>

#include "cloth_problem.hpp"

namespace drench::reference {
namespace {

using Eigen::Vector3d;

/// t(o): the part of a compression o > 0 that a step corrects; factor: density_correction; share: s of Eq. (24).
double corrected(double over, double factor, double share) {
  constexpr double most = 0.1;
  return share * std::max(over / 2, std::min(factor * over, most));
}

/// Where stage cloth has left the nodes: x⁰ + Δt v, m.
Vectors end_of_step(const ReferenceState& state, double dt) {
  Vectors x;
  for (Index n = 0; n < state.s.node_count(); ++n) {
    x.push_back(vec(state.s.node_position[n]) + dt * vec(state.s.node_velocity[n]));
  }
  return x;
}

/// The cloth's implicit step, which goes on while the pressure changes.
class ElasticCloth : public ClothResponse {
 public:
  /// `load`: the node forces that stage cloth has seen, N.
  /// `converged`: what stage cloth came to.
  ElasticCloth(const ReferenceState& state, const StepInfo& info, const Vectors& load, bool converged)
      : cloth_converged_(converged),
        problem_(state, info),
        began_(end_of_step(state, info.dt)),
        load_(load),
        iteration_(problem_, began_) {
    internal_ = problem_.internal_force(began_);
  }

  Vectors velocities(const Vectors& node_force) override {
    for (Index n = 0; n < problem_.model().mesh.nodes(); ++n) {
      if (!problem_.is_free(n)) continue;
      const HostState& s = problem_.state.s;
      const Vector3d contact = vec(s.node_contact_force[n]) + vec(s.node_friction_force[n]);
      const Vector3d change = node_force[n] - load_[n] - internal_[n] - contact;
      problem_.target[n] = began_[n] + problem_.dt * problem_.dt / problem_.mass[n] * change;
    }
    iteration_.move_on();
    const int most = cloth_iterations_per_pressure(problem_.model().scene.cloth_solver, iteration_.iterations());
    int count = 0;
    do {
      iteration_.advance(10);
      residual_ = iteration_.check();
      count += 10;
    } while (residual_ > 1 && count < most);
    Vectors v;
    for (std::size_t n = 0; n < began_.size(); ++n) v.push_back((iteration_.x()[n] - problem_.start[n]) / problem_.dt);
    return v;
  }

  bool converged() override { return residual_ <= 1; }
  bool stalls() override { return !converged() && !cloth_converged_ && coupled_.stalls(residual_); }

  void accept(ReferenceState& state, const Vectors& node_force) override {
    if (!converged()) iteration_.line_search();
    const Vectors& x = iteration_.x();
    const Vectors internal = problem_.internal_force(x);
    for (Index n = 0; n < state.s.node_count(); ++n) {
      if (problem_.is_free(n)) {
        state.s.node_pin_force[n] = arr(vec(state.s.node_pin_force[n]) + problem_.held[n] * (began_[n] - x[n]));
        state.s.node_velocity[n] = arr((x[n] - problem_.start[n]) / problem_.dt);
        continue;
      }
      const Vector3d more = internal[n] - internal_[n] + node_force[n] - load_[n];
      state.s.node_pin_force[n] = arr(vec(state.s.node_pin_force[n]) - more);
    }
  }

  int iterations() const { return iteration_.iterations(); }
  double residual() const { return residual_; }

 private:
  bool cloth_converged_;
  ClothProblem problem_;
  Vectors began_, load_, internal_;
  ClothIteration iteration_;
  double residual_ = 0;
  CoupledProgress coupled_;
};

/// Mean of max(0, r_i) at the velocities that the solve begins with, 1.
double mean_source(ReferenceState& state, const StepInfo& info, const std::vector<bool>& active,
                   const std::function<double(Index, double)>& compression) {
  Vectors fluid, nodes;
  for (const Vec3& v : state.s.fluid_velocity) fluid.push_back(vec(v));
  for (const Vec3& v : state.s.node_velocity) nodes.push_back(vec(v));
  respond_bodies(state, std::vector<double>(fluid.size(), 0.0), info);
  const std::vector<double> rate = density_rate(state, fluid, nodes);
  double sum = 0;
  for (Index i = 0; i < state.s.fluid_count(); ++i)
    if (active[i]) sum += std::max(0.0, compression(i, rate[i]));
  return fluid.empty() ? 0 : sum / static_cast<double>(fluid.size());
}

}  // namespace

void pressure(ReferenceState& state, const StepInfo& info, StepReport& report) {
  const HostState& s = state.s;
  const double ramp = emission_ramp(state.model), correction = state.model.scene.fluid.solver.density_correction;
  std::vector<bool> active(state.alpha.size());
  for (std::size_t i = 0; i < active.size(); ++i) active[i] = state.alpha[i] != 0;
  std::vector<double> compressed(active.size(), 0.0);  // β max(0, δ_adv − 1) of the last iteration
  const auto compression = [&](Index i, double rate) {
    const double beta = source_ramp(s, i, ramp);
    double over = s.fluid_density_ratio[i] - 1;
    if (state.contact_alpha[i] > 0) over = std::max(0.0, over);
    compressed[i] = beta * std::max(0.0, s.fluid_density_ratio[i] - 1 + info.dt * rate);
    return beta * ((over > 0 ? corrected(over, correction, info.correction_share) : over) + info.dt * rate);
  };
  const auto approach = [&](Index i, double rate) { return active[i] ? source_ramp(s, i, ramp) * info.dt * rate : 0; };
  const Residuals residuals{compression, approach};
  clear_inactive(state);
  double tolerance = correction * state.model.density_tolerance();
  if (const auto part = state.model.scene.fluid.solver.source_error)
    tolerance = std::min(tolerance, std::max(*part * mean_source(state, info, active, compression), 1e-4 * tolerance));
  std::vector<double>& kappa = state.s.fluid_kappa_density;
  SolveResult result;
  if (state.model.has_moving_cloth()) {
    ElasticCloth cloth(state, info, pressure_response(state, kappa).node_force, report.cloth_converged);
    result = solve_pressure(state, kappa, active, tolerance, info, cloth, residuals, info.density_start);
    report.cloth_iterations += cloth.iterations();
    if (cloth.iterations() > 0) report.note_cloth_residual(cloth.residual());
  } else {
    FreeCloth cloth(state, info.dt);
    result = solve_pressure(state, kappa, active, tolerance, info, cloth, residuals, info.density_start);
  }
  report.density_iterations = result.iterations;
  if (state.model.only_liquid_answers()) report.density_start = result.start;
  report.density_error = 0;
  report.density_error_max = 0;
  for (const double c : compressed) {
    report.density_error += c / static_cast<double>(compressed.size());
    report.density_error_max = std::max(report.density_error_max, c);
  }
  report.density_converged = result.converged;
}

}  // namespace drench::reference
