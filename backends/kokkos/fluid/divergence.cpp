// Stage divergence (src/stages/divergence.hpp).

#include "fluid/solve.hpp"
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
  double last_start;  // of the step before
  NormScale scale;

  DivergenceUpdate update(Real relaxation) const {
    const PressureWork& work = system.work;
    return {.active = work.active,
            .alpha = std::as_const(system.fluid).alpha,
            .kappa = std::as_const(system.kappa),
            .last = work.last_kappa,
            .next = system.work.next_kappa,
            .factor = relaxation / Real(system.dt),
            .scale = scale};
  }
  bool scales_start() const { return system.constants.model.scales_start(last_start); }
  StartResidual start_residual(Real relaxation) const {
    const Real dt = Real(system.dt);
    return {.ratio = {},
            .alpha = system.fluid.alpha,
            .active = system.work.active,
            .correction = {},
            .dt = dt,
            .factor = relaxation / (dt * dt),
            .density = false};
  }
  void note_start(double mean) const {
    if (system.constants.model.only_liquid_answers()) report.divergence_start = mean / limits.divergence_error;
  }
  IterationNorms norms(const IterationNorms& sums) const { return sums; }
  double scaled(const IterationNorms& n) const {
    return system.dt / system.all() * (scale.residual(n) + scale.complementarity(n));
  }
  bool converged(int iteration, const IterationNorms& sums) const {
    report.divergence_iterations = iteration;
    report.divergence_error = system.dt / system.all() * scale.residual(sums);
    report.divergence_converged = report.divergence_error <= limits.divergence_error &&
                                  system.dt / system.all() * scale.complementarity(sums) <= limits.divergence_error;
    return report.divergence_converged;
  }
  bool gives_up() const { return false; }
};

}  // namespace

MemoryEstimate divergence_bytes(const Sizing& s) {
  MemoryEstimate sum;
  sum.particles = particle_room(s) * (pressure_work_bytes(s) + 1);  // active
  if (!s.gpu || s.real != sizeof(float)) return sum;
  // of the lean iterations: packed, liquid_rate, other_kappa; base_contact, other_contact_pressure
  sum.particles += particle_room(s) * (6 * s.real + (s.size.samples > 0 ? 2 * s.real : 0));
  return sum;
}

void divergence(const Constants& constants, Fluid& fluid, const NeighborLists& lists, Bodies& bodies, Cloth& cloth,
                PressureWork& work, const StepInfo& info, StepReport& report) {
  if (fluid.particles.total == 0) return;
  look_for_contacts(bodies, info);
  allocate_pressure_work(work, fluid);
  make_room(work.active, "drench::pressure::active", fluid.particles.capacity());
  PressureSystem system{.constants = constants,
                        .fluid = fluid,
                        .lists = lists,
                        .bodies = bodies,
                        .cloth = cloth,
                        .work = work,
                        .kappa = fluid.particles.kappa_divergence,
                        .dt = info.dt};
  warm_start(system);
  if (system.has_cloth()) refresh_inverse_mass(constants, cloth);
  const FluidSolverScene& limits = constants.model.scene.fluid.solver;
  DivergenceProblem problem{system, limits, report, info.divergence_start,
                            NormScale(system.all(), 1 / info.dt, system.restart_unit())};
  solve_pressure(system, limits, problem);
}

}  // namespace drench::kokkos_backend
