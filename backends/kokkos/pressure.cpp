// Stage pressure (src/stages/pressure.hpp).

#include "pressure_system.hpp"
#include "primitives/reduce.hpp"

namespace drench::kokkos_backend {

void pressure(Device& d, const StepInfo& info, StepReport& report) {
  const FluidSolverScene& solver = d.model.scene.fluid.solver;
  const Index n = d.fluid.count;
  if (n == 0) return;
  const Real dt = Real(info.dt), ramp = d.emission_ramp;
  const auto kappa = d.fluid.kappa_density, alpha = d.work.alpha, rate = d.work.rate, ratio = d.fluid.density_ratio;
  const auto age = d.fluid.age;
  const auto origin = d.fluid.origin;
  const auto residual = d.work.residual;
  parallel(
      "drench::pressure::warm_start", n, KOKKOS_LAMBDA(const Index i) {
        if (alpha(i) == 0) kappa(i) = 0;
      });
  if (d.samples.count > 0) refresh_inverse_mass(d);
  for (int iteration = 1;; ++iteration) {
    predict_velocities(d, kappa, dt);
    compression_rate(d);
    parallel(
        "drench::pressure::residual", n, KOKKOS_LAMBDA(const Index i) {
          const bool fresh = origin(i) == static_cast<std::uint8_t>(Origin::cloth) && age(i) < ramp;
          const Real beta = alpha(i) == 0 ? Real(0) : fresh ? age(i) / ramp : Real(1);
          residual(i) = beta * (ratio(i) - 1 + dt * rate(i));
        });
    report.density_iterations = iteration;
    const Real factor = Real(0.5) / (dt * dt);
    report.density_error = ordered_sum(
                               "drench::pressure::error", n,
                               KOKKOS_LAMBDA(const Index i) { return residual(i) > 0 ? double(residual(i)) : 0.0; }) /
                           n;
    const double excess =
        ordered_sum(
            "drench::pressure::excess", n,
            KOKKOS_LAMBDA(const Index i) {
              return excess_pressure(double(residual(i)), double(kappa(i)), double(factor * alpha(i)));
            }) /
        n;
    report.density_converged = report.density_error <= solver.density_error && excess <= solver.density_error;
    if ((report.density_converged && iteration >= solver.min_iterations) || iteration >= solver.max_iterations) break;
    parallel(
        "drench::pressure::update", n, KOKKOS_LAMBDA(const Index i) {
          const Real k = kappa(i) + factor * alpha(i) * residual(i);
          kappa(i) = k > 0 ? k : Real(0);
        });
  }
  report.density_error_max = maximum(
      "drench::pressure::error_max", n,
      KOKKOS_LAMBDA(const Index i) { return Kokkos::fmax(double(residual(i)), 0.0); });
  accept_velocities(d, dt);
}

}  // namespace drench::kokkos_backend
