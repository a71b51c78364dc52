// Stage pressure (src/stages/pressure.hpp).

#include <optional>

#include "fluid/stages.hpp"

namespace drench::kokkos_backend {
namespace {

/// t(o): the part of the density error o that a step corrects, o/2 ≤ t(o) ≤ o. Below rest density, o < 0, t(o) = o.
KOKKOS_INLINE_FUNCTION Real corrected(Real over, Real factor) {
  constexpr Real most = Real(0.1);
  return Kokkos::fmin(over, Kokkos::fmax(Real(0.5) * over, Kokkos::fmin(factor * over, most)));
}

/// The norms of the iteration, and the density error that is left: its sum and maximum.
struct DensitySums {
  IterationNorms norms;
  double error = 0, error_max = 0;
  KOKKOS_INLINE_FUNCTION DensitySums& operator+=(const DensitySums& o) {
    norms += o.norms;
    error += o.error;
    if (o.error_max > error_max) error_max = o.error_max;
    return *this;
  }
};

/// The update of a particle's κ and, where it touches a sheet, of its contact pressure λ.
struct DensityUpdate {
  Entries<const std::uint8_t> origin;
  Entries<const Real> age, alpha, ratio, kappa, last, rate;
  Entries<Real> next;
  // of liquid that can touch sheets
  Entries<const Real> contact_alpha, contact_compliance, contact, last_contact, approach;
  Entries<Real> next_contact;
  Real dt, ramp, correction, factor;
  bool touching;

  /// What counts of a particle that cloth has just given out, 1.
  KOKKOS_INLINE_FUNCTION Real weight(Index i) const {
    const bool fresh = origin(i) == static_cast<std::uint8_t>(Origin::cloth) && age(i) < ramp;
    return alpha(i) == 0 ? Real(0) : fresh ? age(i) / ramp : Real(1);
  }
  KOKKOS_INLINE_FUNCTION IterationNorms update_contact(Index i, Real beta, Real lambda_alpha) const {
    const Real lambda = contact(i), gain = factor * lambda_alpha;
    const Real nearer = beta * dt * (approach(i) - dt * contact_compliance(i) * lambda);
    const Real p = updated(lambda, gain, nearer);
    next_contact(i) = p;
    return lambda_alpha > 0 ? norms_of(nearer, lambda, gain, p, last_contact(i), lambda_alpha) : IterationNorms{};
  }
  KOKKOS_INLINE_FUNCTION DensitySums operator()(const Index i) const {
    const Real beta = weight(i), lambda_alpha = touching ? contact_alpha(i) : Real(0);
    const Real over = lambda_alpha > 0 ? Kokkos::fmax(ratio(i) - 1, Real(0)) : ratio(i) - 1, change = dt * rate(i);
    const Real left = beta * (corrected(over, correction) + change);
    const double error = Kokkos::fmax(double(beta * (ratio(i) - 1 + change)), 0.0);
    const Real gain = factor * alpha(i), k = updated(kappa(i), gain, left);
    next(i) = k;
    IterationNorms norms = norms_of(left, kappa(i), gain, k, last(i), alpha(i));
    if (touching) norms += update_contact(i, beta, lambda_alpha);
    return {norms, error, error};
  }
};

/// δ_i after the step ≤ 1 wherever κ = 0, and = 1 wherever κ > 0, as far as a step corrects it.
struct DensityProblem {
  PressureSystem& system;
  const FluidSolverScene& limits;
  StepReport& report;

  SumUnderWay<DensitySums> begin(Real relaxation, int slot) const {
    const Fluid& fluid = system.fluid;
    const PressureWork& work = system.work;
    const ParticleSet& particles = fluid.particles;
    const Real dt = Real(system.dt);
    const DensityUpdate update{particles.origin,
                               particles.age,
                               fluid.alpha,
                               particles.density_ratio,
                               std::as_const(system.kappa),
                               work.last_kappa,
                               work.density_rate,
                               system.work.next_kappa,
                               fluid.contact.alpha,
                               fluid.contact.compliance,
                               work.contact_pressure,
                               work.last_contact_pressure,
                               work.approach_rate,
                               system.work.next_contact_pressure,
                               dt,
                               system.cloth.emission_ramp,
                               Real(limits.density_correction),
                               relaxation / (dt * dt),
                               system.touching};
    return begin_ordered<DensitySums>("drench::pressure::residual", system.count(), update, slot);
  }
  IterationNorms norms(const DensitySums& sums) const { return sums.norms; }
  double scaled(const IterationNorms& n) const { return (n.residual + n.complementarity) / system.count(); }
  bool converged(int iteration, const DensitySums& sums) const {
    const Index n = system.count();
    const double tolerance = limits.density_correction * limits.density_error;
    report.density_iterations = iteration;
    report.density_error = sums.error / n;
    report.density_error_max = sums.error_max;
    report.density_converged = sums.norms.residual / n <= tolerance && sums.norms.complementarity / n <= tolerance;
    if (system.elastic && report.density_converged) report.density_converged = system.elastic->progress().residual <= 1;
    return report.density_converged;
  }
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
  if (fluid.particles.count == 0) return;
  place_solids(constants, bodies, info.dt);
  warm_start_density(fluid, cloth, work);
  PressureSystem system{constants, fluid, lists, bodies, cloth, work, fluid.particles.kappa_density, info.dt};
  system.touching = has_sheet_contact(constants, cloth);
  if (system.touching) allocate_contact(work, fluid);
  std::optional<ElasticSheets> elastic;
  if (system.has_cloth()) {
    refresh_inverse_mass(constants, cloth);
    if (constants.model.has_moving_cloth()) {
      load_cloth(constants, fluid, lists, work, cloth);
      system.elastic = &elastic.emplace(constants, bodies, cloth, solver, Real(info.dt));
      elastic->start();
    }
  }
  const FluidSolverScene& limits = constants.model.scene.fluid.solver;
  DensityProblem problem{system, limits, report};
  solve_pressure(system, limits, problem);
  if (!elastic) return;
  const ClothProgress& progress = elastic->progress();
  report.cloth_iterations += progress.iterations;
  report.note_cloth_residual(progress.residual);
}

}  // namespace drench::kokkos_backend
