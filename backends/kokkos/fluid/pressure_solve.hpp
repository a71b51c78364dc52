#pragma once
// The pressure solve of DFSPH, which stages divergence and pressure share: projected Jacobi with Nesterov's momentum
// and restarts, coupled to cloth and bodies. Laws: docs/theory/liquid.md.

#include "core/reduce.hpp"
#include "coupling/elastic_sheets.hpp"
#include "coupling/pressure_work.hpp"
#include "fluid/density_operator.hpp"

namespace drench::kokkos_backend {

/// What a solve reads and writes. `kappa` is the multiplier that it solves for.
struct PressureSystem {
  const Constants& constants;
  Fluid& fluid;
  const NeighborLists& lists;
  Bodies& bodies;
  Cloth& cloth;
  PressureWork& work;
  Field<Real>& kappa;
  double dt;                         // s
  bool touching = false;             // with the contact pressure λ of liquid that touches sheets
  ElasticSheets* elastic = nullptr;  // the cloth inside the solve; null: nodes answer with their inertia alone
  bool lean = false;                 // iterates on what has changed since a full evaluation (fluid/lean_pressure.hpp)
  bool keep_liquid_rate = false;     // that evaluation is the next one
  bool starts = true;                // no evaluation has been yet

  Index count() const { return fluid.particles.count; }
  /// Of all ranks.
  double all() const { return static_cast<double>(fluid.particles.total); }
  /// m²/s⁴: of the scalar product that decides about a restart, where a residual is a density error of 1.
  double restart_unit() const { return double(constants.spacing) * double(constants.spacing) / (dt * dt * dt * dt); }
  bool has_cloth() const { return cloth.samples.count > 0; }
  /// Is any of the liquid beside cloth?
  bool has_sheets() const { return has_cloth() && lists.sheet_rows.count > 0; }
  /// The sheets beside the liquid, with the nodes' velocities as the cloth has answered.
  SheetsOfParticles sheets_of_particles() const;
  /// The discrete divergence over the step's pairs. `position`: of the particles, with κ for the adjoint.
  DensityOperator divergence(const Entries<const Real4>& position, const SheetsOfParticles& sheets) const;
};

/// work.predicted = v_i + Δt a_i(κ, λ), and κ_i.
void predict_liquid(PressureSystem& system);
/// One evaluation: κ and λ → the velocities that they leave, what cloth and bodies answer, and the density rates.
void apply_pressure(PressureSystem& system);
/// The liquid and the bodies take the predicted velocities; so does cloth that answers with its inertia alone.
void accept_pressure(PressureSystem& system);

/// What an iteration is judged by, of one particle: max(0, residual); how much pressure is too high (complementarity);
/// the scalar product that decides about a restart; the largest residual, infinite for one that is no number.
struct RowNorms {
  Real residual = 0, complementarity = 0, restart = 0, largest = 0;
  KOKKOS_INLINE_FUNCTION RowNorms& operator+=(const RowNorms& o) {
    residual += o.residual;
    complementarity += o.complementarity;
    restart += o.restart;
    if (o.largest > largest) largest = o.largest;
    return *this;
  }
};

/// The same summed over the particles, the same on any number of threads and of ranks.
struct IterationNorms {
  std::int64_t residual = 0, complementarity = 0;
  ExactSum restart;
  double largest = 0;
  KOKKOS_INLINE_FUNCTION IterationNorms& operator+=(const IterationNorms& o) {
    residual += o.residual;
    complementarity += o.complementarity;
    restart += o.restart;
    if (o.largest > largest) largest = o.largest;
    return *this;
  }
  void visit(OverRanks& all) { all.sum(residual).sum(complementarity).sum(restart).maximum(largest); }
};

/// How the norms of all particles of a solve add up. A unit is a density error of 1 in a step.
struct NormScale {
  ErrorScale error;
  ExactScale restart;

  NormScale() = default;
  /// `unit`: a density error of 1 in the solve's residuals; `restart_unit`: PressureSystem's.
  NormScale(double particles, double unit, double restart_unit)
      : error(particles, unit), restart(particles, restart_unit) {}
  KOKKOS_INLINE_FUNCTION IterationNorms exact(const RowNorms& n) const {
    return {error(n.residual), error(n.complementarity), restart(n.restart), n.largest};
  }
  /// In the solve's unit.
  double residual(const IterationNorms& n) const {
    return n.largest < INFINITY ? error.value(n.residual) : static_cast<double>(INFINITY);
  }
  double complementarity(const IterationNorms& n) const { return error.value(n.complementarity); }
};

/// One projected Jacobi update, max(0, κ + gain · residual) with gain = ω α/Δt^k.
KOKKOS_INLINE_FUNCTION Real updated(Real kappa, Real gain, Real residual) {
  const Real k = kappa + gain * residual;
  return k > 0 ? k : Real(0);
}

/// The complementarity residual: how much too high a particle's pressure is, in units of the residual. It is −residual
/// where that is negative, at most what lowering κ to 0 in one update can remove, and 0 elsewhere.
KOKKOS_INLINE_FUNCTION Real complementarity(Real residual, Real kappa, Real gain) {
  if (residual >= 0 || kappa <= 0 || gain <= 0) return 0;
  const Real most = kappa / gain;
  return -residual < most ? -residual : most;
}

/// The norms of one unknown: `alpha` its Jacobi factor, `next` its update, `last` the update before.
KOKKOS_INLINE_FUNCTION RowNorms norms_of(Real residual, Real kappa, Real gain, Real next, Real last, Real alpha) {
  return {residual > 0 ? residual : Real(0), complementarity(residual, kappa, gain),
          alpha > 0 ? (kappa - next) * (next - last) / alpha : Real(0),
          Kokkos::isfinite(residual) ? residual : Real(INFINITY)};
}

/// The iterates κ and λ.
class PressureIteration {
 public:
  explicit PressureIteration(PressureSystem& system)
      : system_(system), relaxation_(Real(system.constants.model.relaxation)) {}
  /// Begins at κ and at λ = 0. Not in the constructor: nvcc wants kernels in functions that have an address.
  void start();
  /// ω of the next update.
  Real relaxation() const { return relaxation_; }
  /// Nesterov's weight of the step after the next update, unless that restarts.
  Real momentum() const;
  /// κ := the next point, from work.next_kappa and work.last_kappa; λ likewise. `residual`: residual + complementarity
  /// of the κ that is left, `restart`: of the norms. `stepped`: the update has left the next point, without a restart,
  /// in work.other_kappa and work.other_contact_pressure.
  void advance(double residual, double restart, bool stepped);
  /// The first advance does not depend on the residual; `saw_first` hands that in before the second.
  void advance_first() { step(); }
  void saw_first(double residual) { smallest_ = last_ = residual; }
  /// Nesterov's step with his next weight. (Public for nvcc's sake, as take_step.)
  void step();
  /// The step that an update has left, or one with a weight of 0 in its place.
  void take_step(bool restarts);

 private:
  static constexpr double most_growth = 4;
  static double next(double weight);

  PressureSystem& system_;
  Real relaxation_;
  double weight_ = 1, smallest_ = 1e300, last_ = 1e300;
};

}  // namespace drench::kokkos_backend
