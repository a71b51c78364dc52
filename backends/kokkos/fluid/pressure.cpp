// Stage pressure (src/stages/pressure.hpp).

#include "stages/pressure.hpp"

#include <algorithm>
#include <optional>

#include "cloth/pins.hpp"
#include "fluid/solve.hpp"
#include "fluid/stages.hpp"

namespace drench::kokkos_backend {
namespace {

/// δ_i after the step ≤ 1 wherever κ = 0, and = 1 wherever κ > 0, as far as a step corrects it.
struct DensityProblem {
  PressureSystem& system;
  const FluidSolverScene& limits;
  StepReport& report;
  double last_start;  // of the step before
  Correction correction;
  double most;  // 1: of the tolerance, where the step's own compression sets it
  NormScale scale;
  CoupledProgress coupled{};
  bool cloth_stalls = false;

  DensityUpdate update(Real relaxation) const {
    const Fluid& fluid = system.fluid;
    const PressureWork& work = system.work;
    const ParticleSet& particles = fluid.particles;
    const Real dt = Real(system.dt);
    return {.origin = particles.origin,
            .age = particles.age,
            .alpha = fluid.alpha,
            .ratio = particles.density_ratio,
            .kappa = std::as_const(system.kappa),
            .last = work.last_kappa,
            .next = system.work.next_kappa,
            .contact_alpha = fluid.contact.alpha,
            .contact_compliance = fluid.contact.compliance,
            .contact = work.contact_pressure,
            .last_contact = work.last_contact_pressure,
            .next_contact = system.work.next_contact_pressure,
            .dt = dt,
            .ramp = system.cloth.emission_ramp,
            .correction = correction,
            .factor = relaxation / (dt * dt),
            .touching = system.touching,
            .scale = scale};
  }
  double tolerance() const { return std::min(most, fixed_tolerance()); }
  double fixed_tolerance() const { return limits.density_correction * system.constants.model.density_tolerance(); }
  /// No more than a part of the step's own compression is left, as far as rounding lets that be.
  void limit_by_source() {
    constexpr double least = 1e-4;
    if (limits.source_error)
      most = std::max(*limits.source_error * mean_source(system, update(0)), least * fixed_tolerance());
  }
  bool scales_start() const { return system.constants.model.scales_start(last_start); }
  StartResidual start_residual(Real relaxation) const {
    const Real dt = Real(system.dt);
    return {.ratio = system.fluid.particles.density_ratio,
            .alpha = system.fluid.alpha,
            .active = {},
            .correction = correction,
            .dt = dt,
            .factor = relaxation / (dt * dt),
            .density = true};
  }
  void note_start(double mean) const {
    if (system.constants.model.only_liquid_answers()) report.density_start = mean / tolerance();
  }
  IterationNorms norms(const DensitySums& sums) const { return sums.norms; }
  double scaled(const IterationNorms& n) const { return (scale.residual(n) + scale.complementarity(n)) / system.all(); }
  bool converged(int iteration, const DensitySums& sums) {
    const double n = system.all();
    report.density_iterations = iteration;
    report.density_error = sums.norms.largest < INFINITY ? scale.error.value(sums.error) / n : INFINITY;
    report.density_error_max = sums.error_max;
    report.density_converged =
        scale.residual(sums.norms) / n <= tolerance() && scale.complementarity(sums.norms) / n <= tolerance();
    if (system.elastic && report.density_converged) {
      const double residual = system.elastic->progress().residual;
      report.density_converged = residual <= 1;
      cloth_stalls = iteration >= limits.min_iterations && !report.density_converged && !report.cloth_converged &&
                     coupled.stalls(residual);
    }
    return report.density_converged;
  }
  bool gives_up() const { return cloth_stalls; }
};

void allocate_contact(PressureWork& work, const Fluid& fluid) {
  const std::size_t n = fluid.particles.capacity();
  make_room(work.contact_pressure, "drench::pressure::contact", n);
  make_room(work.next_contact_pressure, "drench::pressure::next_contact", n);
  make_room(work.last_contact_pressure, "drench::pressure::last_contact", n);
  make_room(work.approach_rate, "drench::pressure::approach_rate", n);
}

}  // namespace

MemoryEstimate pressure_bytes(const Sizing& s) {
  MemoryEstimate sum;
  if (s.size.samples > 0) sum.particles = particle_room(s) * 4 * s.real;
  return sum;
}

void pressure(const Constants& constants, Fluid& fluid, const NeighborLists& lists, Bodies& bodies, Cloth& cloth,
              PressureWork& work, ClothSolverWork& solver, const StepInfo& info, StepReport& report) {
  if (fluid.particles.total == 0) return;
  place_solids(constants, bodies, info);
  look_for_contacts(bodies, info);
  warm_start_density(fluid, work);
  PressureSystem system{.constants = constants,
                        .fluid = fluid,
                        .lists = lists,
                        .bodies = bodies,
                        .cloth = cloth,
                        .work = work,
                        .kappa = fluid.particles.kappa_density,
                        .dt = info.dt};
  system.touching = has_sheet_contact(constants, cloth);
  if (system.touching) allocate_contact(work, fluid);
  std::optional<ElasticSheets> elastic;
  if (system.has_cloth()) {
    refresh_inverse_mass(constants, cloth);
    if (constants.model.has_moving_cloth()) {
      place_pins(constants, cloth, info);
      fluid.exchange.halo(system.kappa);
      load_cloth({lists.sheet_rows, fluid.exchange, system.kappa}, cloth);
      system.elastic = &elastic.emplace(constants, bodies, cloth, solver, Real(info.dt));
      elastic->start();
    }
  }
  const FluidSolverScene& limits = constants.model.scene.fluid.solver;
  const Correction correction{Real(limits.density_correction), Real(info.correction_share)};
  DensityProblem problem{.system = system,
                         .limits = limits,
                         .report = report,
                         .last_start = info.density_start,
                         .correction = correction,
                         .most = 1e300,
                         .scale = NormScale(system.all(), 1, system.restart_unit())};
  problem.limit_by_source();
  solve_pressure(system, limits, problem);
  if (!elastic) return;
  const ClothProgress& progress = elastic->progress();
  report.cloth_iterations += progress.iterations;
  report.note_cloth_residual(progress.residual);
}

}  // namespace drench::kokkos_backend
