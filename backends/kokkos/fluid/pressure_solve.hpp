#pragma once
// The pressure solve of DFSPH, which stages divergence and pressure share: projected Jacobi with Nesterov's momentum and
// restarts, coupled to cloth and bodies. Laws: docs/theory/liquid.md.

#include "core/reduce.hpp"
#include "coupling/elastic_sheets.hpp"
#include "coupling/pressure_work.hpp"

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

  Index count() const { return fluid.particles.count; }
  bool has_cloth() const { return cloth.samples.count > 0; }
};

/// One evaluation: κ and λ → the velocities that they leave, what cloth and bodies answer, and the density rates.
void apply_pressure(PressureSystem& system);
/// The liquid and the bodies take the predicted velocities; so does cloth that answers with its inertia alone.
void accept_pressure(PressureSystem& system);

/// What an iteration is judged by, summed over the particles: max(0, residual); how much pressure is too high
/// (complementarity); the scalar product that decides about a restart.
struct IterationNorms {
  double residual = 0, complementarity = 0, restart = 0;
  KOKKOS_INLINE_FUNCTION IterationNorms& operator+=(const IterationNorms& o) {
    residual += o.residual;
    complementarity += o.complementarity;
    restart += o.restart;
    return *this;
  }
};

/// One projected Jacobi update, max(0, κ + gain · residual) with gain = ω α/Δt^k.
KOKKOS_INLINE_FUNCTION Real updated(Real kappa, Real gain, Real residual) {
  const Real k = kappa + gain * residual;
  return k > 0 ? k : Real(0);
}

/// The complementarity residual: how much too high a particle's pressure is, in units of the residual. It is −residual
/// where that is negative, at most what lowering κ to 0 in one update can remove, and 0 elsewhere.
KOKKOS_INLINE_FUNCTION double complementarity(double residual, double kappa, double gain) {
  if (residual >= 0 || kappa <= 0 || gain <= 0) return 0;
  const double most = kappa / gain;
  return -residual < most ? -residual : most;
}

/// The norms of one unknown: `alpha` its Jacobi factor, `next` its update, `last` the update before.
KOKKOS_INLINE_FUNCTION IterationNorms norms_of(Real residual, Real kappa, Real gain, Real next, Real last, Real alpha) {
  return {residual > 0 ? double(residual) : 0.0, complementarity(double(residual), double(kappa), double(gain)),
          alpha > 0 ? double(kappa - next) * double(next - last) / double(alpha) : 0.0};
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
  /// κ := the next point, from work.next_kappa and work.last_kappa; λ likewise. `residual`: residual + complementarity of
  /// the κ that is left, `restart`: of the norms.
  void advance(double residual, double restart);
  /// The first advance does not depend on the residual; `saw_first` hands that in before the second.
  void advance_first() { move_on(); }
  void saw_first(double residual) { smallest_ = last_ = residual; }
  /// The next of Nesterov's weights, and κ and λ with it. (Public for nvcc's sake.)
  void move_on();

 private:
  static constexpr double most_growth = 4;
  PressureSystem& system_;
  Real relaxation_;
  double weight_ = 1, smallest_ = 1e300, last_ = 1e300;
};

/// Solves for κ. A `Problem` launches the update and the sums that judge it in begin(relaxation, slot) → SumUnderWay<Sums>.
/// It makes norms(sums) → IterationNorms of them and scaled(norms), the residual + complementarity that iterations compare.
/// converged(iteration, sums) judges, and writes the report.
template <class Problem>
void solve_pressure(PressureSystem& system, const FluidSolverScene& limits, Problem& problem) {
  PressureIteration iterate(system);
  iterate.start();
  // Iteration 1 cannot be the last then: the host does not wait for its sums.
  const bool first_unseen = limits.min_iterations > 1;
  decltype(problem.begin(iterate.relaxation(), 0)) first;
  for (int iteration = 1;; ++iteration) {
    apply_pressure(system);
    const auto under_way = problem.begin(iterate.relaxation(), iteration % 2);
    if (iteration == 1 && first_unseen) {
      first = under_way;
      iterate.advance_first();
      continue;
    }
    const auto sums = under_way.wait();
    if (iteration == 2 && first_unseen) iterate.saw_first(problem.scaled(problem.norms(first.arrived())));
    const bool converged = problem.converged(iteration, sums);
    if ((converged && iteration >= limits.min_iterations) || iteration >= limits.max_iterations) break;
    const IterationNorms norms = problem.norms(sums);
    iterate.advance(problem.scaled(norms), norms.restart);
  }
  accept_pressure(system);
}

}  // namespace drench::kokkos_backend
