#include "fluid/scaled_start.hpp"

#include <algorithm>

namespace drench::kokkos_backend {
namespace {

constexpr double most_scale = 4;

/// Two velocities of a particle, of which one pass over its pairs finds both rates.
struct TwoVelocities {
  Real3 predicted, free;
  KOKKOS_INLINE_FUNCTION friend TwoVelocities operator-(const TwoVelocities& a, const TwoVelocities& b) {
    return {a.predicted - b.predicted, a.free - b.free};
  }
};
struct TwoRates {
  Real predicted = 0, free = 0;
  KOKKOS_INLINE_FUNCTION TwoRates& operator+=(const TwoRates& o) {
    predicted += o.predicted;
    free += o.free;
    return *this;
  }
};
KOKKOS_INLINE_FUNCTION TwoRates pair_rate(Real factor, const TwoVelocities& v, const Real3& x) {
  const Real3 gradient = factor * x;
  return {dot(v.predicted, gradient), dot(v.free, gradient)};
}

/// work.density_rate of the predicted velocities, less what yields, and work.free_rate of those without any pressure.
void measure_rates(PressureSystem& system) {
  const Real dt = Real(system.dt);
  const PressureWork& work = system.work;
  const DensityOperator divergence = system.divergence(work.position_kappa, {});
  const Entries<const Real3> ub = system.bodies.seen_velocity(),
                             free_velocity = std::as_const(system.fluid).particles.velocity;
  const Entries<const Real4> predicted = work.predicted;
  const Entries<const Real> compliance = std::as_const(system.fluid).compliance;
  const Entries<Real> rate = system.work.density_rate, free_rate = system.work.free_rate;
  parallel(
      "drench::pressure::start_rate", system.count(), KOKKOS_LAMBDA(const Index i) {
        const auto velocities = [&](Index j) { return TwoVelocities{predicted(j).xyz(), free_velocity(j)}; };
        const TwoVelocities own = velocities(i);
        TwoRates sum;
        divergence.add_liquid(i, own, velocities, sum);
        divergence.add_walls(
            i, own,
            [&](Index b) {
              return TwoVelocities{ub(b), ub(b)};
            },
            sum);
        rate(i) = sum.predicted - dt * compliance(i) * divergence.position(i).w;
        free_rate(i) = sum.free;
      });
}

/// The work and the answer of Eq. 20a; residual and complementarity.
struct StartSums {
  ExactSum work, answer;
  std::int64_t residual = 0;
  KOKKOS_INLINE_FUNCTION StartSums& operator+=(const StartSums& o) {
    work += o.work;
    answer += o.answer;
    residual += o.residual;
    return *this;
  }
  void visit(OverRanks& all) { all.sum(work).sum(answer).sum(residual); }
};

StartSums judge_start(const PressureSystem& system, const StartResidual& residual, const ExactScale& energy,
                      const ErrorScale& error) {
  const Entries<const Real> volume = system.fluid.volume, kappa = std::as_const(system.kappa),
                            rate = std::as_const(system.work).density_rate,
                            free_rate = std::as_const(system.work).free_rate;
  const StartSums own = ordered<StartSums>(
      "drench::pressure::start_work", system.count(), KOKKOS_LAMBDA(const Index i) {
        if (!residual.counts(i)) return StartSums{};
        const Real r = residual(i, rate(i)), k = kappa(i);
        const double weight = double(volume(i)) * k;
        return StartSums{energy(weight * r), energy(weight * (residual.dt * (free_rate(i) - rate(i)))),
                         error(r > 0 ? r : complementarity(r, k, residual.factor * residual.alpha(i)))};
      });
  return over_ranks(system.constants.ranks, own);
}

/// κ := scale · κ, and what an evaluation finds with it.
void scale_start(PressureSystem& system, Real scale) {
  PressureWork& work = system.work;
  const Entries<Real> kappa = system.kappa, last = work.last_kappa, rate = work.density_rate;
  const Entries<Real4> position_kappa = work.position_kappa, predicted = work.predicted;
  const Entries<const Real3> v = std::as_const(system.fluid).particles.velocity;
  const Entries<const Real> free_rate = std::as_const(work).free_rate;
  parallel(
      "drench::pressure::scale_start", system.count(), KOKKOS_LAMBDA(const Index i) {
        const Real k = scale * kappa(i);
        kappa(i) = last(i) = position_kappa(i).w = k;
        predicted(i) = {v(i) + scale * (predicted(i).xyz() - v(i)), k};
        rate(i) = free_rate(i) + scale * (rate(i) - free_rate(i));
      });
}

}  // namespace

double apply_scaled_start(PressureSystem& system, const StartResidual& residual) {
  make_room(system.work.free_rate, "drench::pressure::free_rate", system.fluid.particles.capacity());
  predict_liquid(system);
  system.fluid.exchange.halo(system.fluid.particles.velocity);
  measure_rates(system);
  const double d = system.constants.spacing;
  const ExactScale energy(
      system.all(), d * d * d * d * d / (system.dt * system.dt));  // of a particle that moves d in a step, over ρ0
  const ErrorScale error(system.all(), 1);
  const StartSums sums = judge_start(system, residual, energy, error);
  const double answer = energy.value(sums.answer);
  if (answer > 0) scale_start(system, Real(std::clamp(1 + energy.value(sums.work) / answer, 0.0, most_scale)));
  return error.value(sums.residual) / system.all();
}

}  // namespace drench::kokkos_backend
