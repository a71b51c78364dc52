// Stage divergence (src/stages/divergence.hpp).

#include "pressure_system.hpp"
#include "primitives/reduce.hpp"
#include "rigid_bodies.hpp"

namespace drench::kokkos_backend {

void divergence(Device& d, const StepInfo& info, StepReport& report) {
  const FluidSolverScene& solver = d.model.scene.fluid.solver;
  const Index n = d.fluid.count;
  if (n == 0) return;
  const Real dt = Real(info.dt);
  const auto kappa = d.fluid.kappa_divergence, alpha = d.work.alpha, rate = d.work.rate;
  const auto nf = d.fluid_fluid.count, nb = d.fluid_boundary.count, ns = d.fluid_sample.count;
  const bool solids = d.boundary.count > 0, cloth = d.samples.count > 0;
  const auto active = d.work.active;
  constexpr Index fewest_neighbors = 20;
  parallel(
      "drench::divergence::warm_start", n, KOKKOS_LAMBDA(const Index i) {
        const Index neighbors = nf(i) + (solids ? nb(i) : 0) + (cloth ? ns(i) : 0);
        active(i) = neighbors >= fewest_neighbors && alpha(i) > 0;
        kappa(i) = active(i) ? Real(0.5) * kappa(i) : Real(0);
      });
  if (cloth) refresh_inverse_mass(d);
  PressureIteration iterate(d, kappa, false);
  iterate.start();
  const auto next = d.work.kappa_next, last = d.work.kappa_last;
  const auto residual = [&](const ThreeSums& sums) { return info.dt / n * (sums.first + sums.second); };
  SumUnderWay<ThreeSums> first;
  for (int iteration = 1;; ++iteration) {
    predict_liquid(d, dt, false);
    if (cloth) {
      cloth_forces(d);
      free_cloth_response(d, dt);
    }
    body_response(d, kappa, info.dt);
    compression_rate(d, kappa, dt, false);
    report.divergence_iterations = iteration;
    const Real factor = iterate.relaxation() / dt;
    const auto under_way = begin_ordered<ThreeSums>(
        "drench::divergence::error", n,
        KOKKOS_LAMBDA(const Index i) {
          next(i) = 0;
          if (!active(i)) return ThreeSums{};
          const Real gain = factor * alpha(i), k = updated(kappa(i), gain, rate(i));
          next(i) = k;
          return ThreeSums{rate(i) > 0 ? double(rate(i)) : 0.0,
                           excess_pressure(double(rate(i)), double(kappa(i)), double(gain)),
                           double(kappa(i) - k) * double(k - last(i)) / double(alpha(i))};
        },
        iteration % 2);
    if (PressureIteration::goes_on_unseen(iteration, solver)) {
      first = under_way;
      iterate.advance_first();
      continue;
    }
    const ThreeSums sums = under_way.wait();
    if (iteration == 2 && PressureIteration::goes_on_unseen(1, solver)) iterate.saw_first(residual(first.arrived()));
    report.divergence_error = info.dt / n * sums.first;
    report.divergence_converged =
        report.divergence_error <= solver.divergence_error && info.dt / n * sums.second <= solver.divergence_error;
    if ((report.divergence_converged && iteration >= solver.min_iterations) || iteration >= solver.max_iterations)
      break;
    iterate.advance(residual(sums), sums.third);
  }
  accept_liquid(d);
  accept_bodies(d, info.dt);
  if (cloth) accept_free_cloth(d, dt);
}

}  // namespace drench::kokkos_backend
