#include "app/failure_report.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace drench {
namespace {

double norm(const Vec3& v) { return std::hypot(v[0], v[1], v[2]); }

/// m/s: of those that are finite.
double fastest(const std::vector<Vec3>& velocities) {
  double most = 0;
  for (const Vec3& v : velocities)
    if (const double speed = norm(v); std::isfinite(speed)) most = std::max(most, speed);
  return most;
}

double distance(const Vec3& a, const Vec3& b) { return norm({a[0] - b[0], a[1] - b[1], a[2] - b[2]}); }

std::string halve(const Model& m) {
  const TimeScene& time = m.scene.time;
  const std::string other = time.mode == TimeMode::cfl     ? fmt::format(" or time.cfl ({:.3g})", time.cfl)
                            : time.mode == TimeMode::error ? fmt::format(" or time.tolerance ({:.3g})", time.tolerance)
                                                           : " or set time.mode: cfl";
  return fmt::format("halve time.step ({:.3g} s){}", time.step, other);
}

std::string ended_at(const char* solver, const char* key, int most, double error, const Model& m) {
  return fmt::format("the {} reached {} ({}) with an error of {:.3g}: raise the limit, or {}", solver, key, most, error,
                     halve(m));
}

}  // namespace

Offenders offenders_of(const RunFailure& failure, const Model& m, const HostState& s) {
  Offenders bad = find_offenders(s);
  switch (failure.kind) {
    case FailureKind::fluid_speed:
      for (Index i = 0; i < s.fluid_count(); ++i)
        if (norm(s.fluid_velocity[static_cast<std::size_t>(i)]) > failure.limit) bad.particles.push_back(i);
      break;
    case FailureKind::cloth_speed:
      for (Index n = 0; n < s.node_count(); ++n)
        if (norm(s.node_velocity[static_cast<std::size_t>(n)]) > failure.limit) bad.nodes.push_back(n);
      break;
    case FailureKind::cloth_stretch:
      for (std::size_t e = 0; e < m.mesh.edge.size(); ++e) {
        const auto [a, b] = m.mesh.edge[e];
        const double length =
            distance(s.node_position[static_cast<std::size_t>(a)], s.node_position[static_cast<std::size_t>(b)]);
        if (length > failure.limit * m.mesh.edge_length[e]) bad.nodes.insert(bad.nodes.end(), {a, b});
      }
      break;
    case FailureKind::density:
      for (Index i = 0; i < s.fluid_count(); ++i)
        if (s.fluid_density_ratio[static_cast<std::size_t>(i)] > 1 + failure.report.density_error)
          bad.particles.push_back(i);
      break;
    case FailureKind::not_finite:
    case FailureKind::time_step:
    case FailureKind::sub_steps:
    case FailureKind::mass:
    case FailureKind::solute:
      break;
  }
  for (auto* list : {&bad.particles, &bad.nodes}) {
    std::sort(list->begin(), list->end());
    list->erase(std::unique(list->begin(), list->end()), list->end());
  }
  return bad;
}

std::string advice(const RunFailure& failure, const Model& m, const HostState& s) {
  const StepReport& r = failure.report;
  const double dt = failure.info.dt > 0 ? failure.info.dt : m.scene.time.step;
  const auto cloth_solve = [&] {
    return ended_at("cloth's solve", "cloth_solver.max_iterations", m.scene.cloth_solver.max_iterations,
                    r.cloth_residual, m);
  };
  if (failure.kind == FailureKind::mass || failure.kind == FailureKind::solute)
    return "this is a bug in drench, not in the scene: please report it with scene.yaml from the output folder";
  if (failure.kind == FailureKind::cloth_speed || failure.kind == FailureKind::cloth_stretch)
    return r.cloth_converged ? halve(m) : cloth_solve();
  if (failure.kind == FailureKind::sub_steps) return "lower time.step or porous.diffusivity, or use larger triangles";
  const FluidSolverScene& solver = m.scene.fluid.solver;
  if (failure.kind == FailureKind::density)
    return ended_at("density solve", "fluid.solver.max_iterations", solver.max_iterations, r.density_error, m);
  const double speed = fastest(s.fluid_velocity), spacings = speed * dt / m.spacing;
  if (m.has_fluid() && spacings > 1)
    return fmt::format("the fastest particle, {:.3g} m/s, moves {:.2g} spacings per step: {}", speed, spacings,
                       halve(m));
  if (m.has_fluid() && std::isfinite(r.density_error) && !r.density_converged)
    return ended_at("density solve", "fluid.solver.max_iterations", solver.max_iterations, r.density_error, m);
  if (m.has_fluid() && std::isfinite(r.divergence_error) && !r.divergence_converged)
    return ended_at("divergence solve", "fluid.solver.max_iterations", solver.max_iterations, r.divergence_error, m);
  if (m.has_moving_cloth() && std::isfinite(r.cloth_residual) && !r.cloth_converged) return cloth_solve();
  return halve(m);
}

}  // namespace drench
