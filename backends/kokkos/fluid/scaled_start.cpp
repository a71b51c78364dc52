#include "fluid/scaled_start.hpp"

#include <algorithm>

#include "coupling/wall.hpp"

namespace drench::kokkos_backend {
namespace {

constexpr double most_scale = 4;

/// work.density_rate of the predicted velocities, less what yields, and work.free_rate of those without any pressure.
void measure_rates(PressureSystem& system) {
  const Bodies& bodies = system.bodies;
  const Real dt = Real(system.dt);
  const PressureWork& work = system.work;
  const Entries<const Real3> ub = bodies.seen_velocity(), xb = bodies.boundary.position,
                             free_velocity = std::as_const(system.fluid).particles.velocity;
  const Entries<const Real4> position_kappa = work.position_kappa, v = work.predicted;
  const Entries<const Real> compliance = std::as_const(system.fluid).compliance;
  const Entries<Real> rate = system.work.density_rate, free_rate = system.work.free_rate;
  const Neighbors lf(system.lists.fluid_fluid), lb(system.lists.fluid_boundary);
  const bool solids = bodies.boundary.count > 0;
  parallel(
      "drench::pressure::start_rate", system.count(), KOKKOS_LAMBDA(const Index i) {
        const Real4 here = position_kappa(i);
        const Real3 xi = here.xyz(), vi = v(i).xyz(), free_vi = free_velocity(i);
        Real sum = 0, free_sum = 0;
        const NeighborRow near = lf.row(i);
        DRENCH_UNROLL
        for (Index k = 0; k < near.count; ++k) {
          const Index j = near(k);
          const Real3 gradient = near.grad_factor(k) * (xi - position_kappa(j).xyz());
          sum += dot(vi - v(j).xyz(), gradient);
          free_sum += dot(free_vi - free_velocity(j), gradient);
        }
        if (solids) {
          const NeighborRow walls = lb.row(i);
          for (Index k = 0; k < walls.count; ++k) {
            const Index b = walls(k);
            const Real3 gradient = (mirrored * walls.grad_factor(k)) * (xi - xb(b));
            sum += dot(vi - ub(b), gradient);
            free_sum += dot(free_vi - ub(b), gradient);
          }
        }
        rate(i) = sum - dt * compliance(i) * here.w;
        free_rate(i) = free_sum;
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
  const ExactScale energy(system.all(), d * d * d * d * d / (system.dt * system.dt));  // of a particle that moves d in a step, over ρ0
  const ErrorScale error(system.all(), 1);
  const StartSums sums = judge_start(system, residual, energy, error);
  const double answer = energy.value(sums.answer);
  if (answer > 0) scale_start(system, Real(std::clamp(1 + energy.value(sums.work) / answer, 0.0, most_scale)));
  return error.value(sums.residual) / system.all();
}

}  // namespace drench::kokkos_backend
