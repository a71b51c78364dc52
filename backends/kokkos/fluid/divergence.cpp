// Stage divergence (src/stages/divergence.hpp).

#include "fluid/stages.hpp"

namespace drench::kokkos_backend {
namespace {

constexpr Index fewest_neighbors = 20;

/// Halves the κ of the last step, and leaves out particles that have too few neighbours for a divergence.
void warm_start(PressureSystem& system) {
  const Fluid& fluid = system.fluid;
  const Entries<Real> kappa = system.kappa;
  const Entries<std::uint8_t> active = system.work.active;
  const Entries<const Real> alpha = fluid.alpha;
  const Entries<const Index> nf = system.lists.fluid_fluid.count, nb = system.lists.fluid_boundary.count,
                             ns = system.lists.fluid_sample.count;
  const bool solids = system.bodies.boundary.count > 0, cloth = system.has_cloth();
  parallel(
      "drench::divergence::warm_start", system.count(), KOKKOS_LAMBDA(const Index i) {
        const Index neighbors = nf(i) + (solids ? nb(i) : 0) + (cloth ? ns(i) : 0);
        active(i) = neighbors >= fewest_neighbors && alpha(i) > 0;
        kappa(i) = active(i) ? Real(0.5) * kappa(i) : Real(0);
      });
}

/// Dδ/Dt ≤ 0 wherever κ = 0, and = 0 wherever κ > 0.
struct DivergenceProblem {
  PressureSystem& system;
  const FluidSolverScene& limits;
  StepReport& report;

  SumUnderWay<IterationNorms> begin(Real relaxation, int slot) const {
    const Entries<const std::uint8_t> active = std::as_const(system.work).active;
    const Entries<const Real> alpha = std::as_const(system.fluid).alpha, kappa = std::as_const(system.kappa),
                              rate = std::as_const(system.work).density_rate,
                              last = std::as_const(system.work).last_kappa;
    const Entries<Real> next = system.work.next_kappa;
    const Real factor = relaxation / Real(system.dt);
    return begin_ordered<IterationNorms>(
        "drench::divergence::error", system.count(),
        KOKKOS_LAMBDA(const Index i) {
          next(i) = 0;
          if (!active(i)) return IterationNorms{};
          const Real gain = factor * alpha(i), k = updated(kappa(i), gain, rate(i));
          next(i) = k;
          return norms_of(rate(i), kappa(i), gain, k, last(i), alpha(i));
        },
        slot);
  }
  IterationNorms norms(const IterationNorms& sums) const { return sums; }
  double scaled(const IterationNorms& n) const {
    return system.dt / system.count() * (n.residual + n.complementarity);
  }
  bool converged(int iteration, const IterationNorms& sums) const {
    report.divergence_iterations = iteration;
    report.divergence_error = system.dt / system.count() * sums.residual;
    report.divergence_converged = report.divergence_error <= limits.divergence_error &&
                                  system.dt / system.count() * sums.complementarity <= limits.divergence_error;
    return report.divergence_converged;
  }
};

}  // namespace

MemoryEstimate divergence_bytes(const Sizing& s) {
  MemoryEstimate sum;
  sum.particles = particle_room(s) * (pressure_work_bytes(s) + 1);  // active
  return sum;
}

void divergence(const Constants& constants, Fluid& fluid, const NeighborLists& lists, Bodies& bodies, Cloth& cloth,
                PressureWork& work, const StepInfo& info, StepReport& report) {
  if (fluid.particles.count == 0) return;
  allocate_pressure_work(work, fluid);
  make_room(work.active, "drench::pressure::active", fluid.particles.capacity());
  PressureSystem system{constants, fluid, lists, bodies, cloth, work, fluid.particles.kappa_divergence, info.dt};
  warm_start(system);
  if (system.has_cloth()) refresh_inverse_mass(constants, cloth);
  const FluidSolverScene& limits = constants.model.scene.fluid.solver;
  DivergenceProblem problem{system, limits, report};
  solve_pressure(system, limits, problem);
}

}  // namespace drench::kokkos_backend
