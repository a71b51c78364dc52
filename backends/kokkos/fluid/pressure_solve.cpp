#include "fluid/pressure_solve.hpp"

#include <algorithm>
#include <cmath>

#include "coupling/body_response.hpp"
#include "coupling/wall_push.hpp"
#include "fluid/lean_pressure.hpp"

namespace drench::kokkos_backend {
namespace {

/// work.density_rate = R_i of the predicted velocities − Δt C_i κ_i, 1/s; touching sheets: work.approach_rate = R'_i
/// too.
void measure_density_rate(PressureSystem& system) {
  const Fluid& fluid = system.fluid;
  const Real dt = Real(system.dt);
  const PressureWork& work = system.work;
  const DensityOperator divergence = system.divergence(work.position_kappa, system.sheets_of_particles());
  const Entries<const Real3> ub = system.bodies.seen_velocity();
  const Entries<const Real4> v = work.predicted;
  const Entries<const Real> compliance = fluid.compliance, kappa = std::as_const(system.kappa);
  const Entries<Real> rate = system.work.density_rate, approach = system.work.approach_rate,
                      liquid_rate = system.work.liquid_rate;
  const bool keep_liquid_rate = system.keep_liquid_rate, touching = system.touching;
  const auto row = KOKKOS_LAMBDA(const Index i) {
    const Real3 vi = v(i).xyz();
    Real sum = 0;
    divergence.add_liquid(i, v, sum);
    if (keep_liquid_rate) liquid_rate(i) = sum;
    divergence.add_walls(i, vi, ub, sum);
    const Real sheet = divergence.approach(i, vi);
    if (touching) approach(i) = sheet;
    rate(i) = sum + sheet - dt * compliance(i) * kappa(i);
  };
  constexpr const char* label = "drench::pressure::density_rate";
  fluid.exchange.inner_rows(label, system.count(), row);
  fluid.exchange.finish_halo();  // of the predicted velocities
  fluid.exchange.outer_rows(label, system.count(), row);
}

/// work.free_rate = R_i of the velocities that a solve begins with, 1/s.
void measure_free_rate(PressureSystem& system) {
  make_room(system.work.free_rate, "drench::pressure::free_rate", system.fluid.particles.capacity());
  system.fluid.exchange.halo(system.fluid.particles.velocity);
  const SheetRows& rows = system.lists.sheet_rows;
  const DensityOperator divergence =
      system.divergence(std::as_const(system.fluid).position_volume,
                        {rows.of_particle, rows.particle_pair, std::as_const(system.cloth).nodes.velocity, Real(1)});
  const Entries<const Real3> ub = system.bodies.boundary.velocity, v = std::as_const(system.fluid).particles.velocity;
  const Entries<Real> rate = system.work.free_rate;
  parallel(
      "drench::pressure::free_rate", system.count(), KOKKOS_LAMBDA(const Index i) {
        const Real3 vi = v(i);
        Real sum = 0;
        divergence.add_liquid(i, vi, v, sum);
        divergence.add_walls(i, vi, ub, sum);
        rate(i) = sum + divergence.approach(i, vi);
      });
}

}  // namespace

SheetsOfParticles PressureSystem::sheets_of_particles() const {
  const SheetRows& rows = lists.sheet_rows;
  if (elastic) return {rows.of_particle, rows.particle_pair, elastic->displacement(), Real(1) / Real(dt)};
  return {rows.of_particle, rows.particle_pair, std::as_const(cloth).nodes.predicted, Real(1)};
}

DensityOperator PressureSystem::divergence(const Entries<const Real4>& position,
                                           const SheetsOfParticles& sheets) const {
  return {.liquid = LiquidPairs(lists.fluid_fluid, constants.kernel, fluid.volume),
          .walls = Neighbors(lists.fluid_boundary),
          .position = position,
          .wall_position = std::as_const(bodies).boundary.position,
          .sheets = sheets,
          .has_walls = bodies.boundary.count > 0,
          .has_sheets = has_sheets()};
}

namespace {

/// The κ of ghosts, which are on their way, comes to where rows see it.
void take_kappa(PressureSystem& system) {
  const Fluid& fluid = system.fluid;
  if (fluid.exchange.alone()) return;
  fluid.exchange.finish_halo();
  const Entries<const Real> kappa = std::as_const(system.kappa);
  const Entries<Real4> position_kappa = system.work.position_kappa;
  const Index first = fluid.particles.count;
  parallel(
      "drench::pressure::ghost_kappa", fluid.particles.ghosts,
      KOKKOS_LAMBDA(const Index k) { position_kappa(first + k).w = kappa(first + k); });
}

}  // namespace

void predict_liquid(PressureSystem& system) {
  const Fluid& fluid = system.fluid;
  fluid.exchange.begin_halo(system.kappa);
  const Real dt = Real(system.dt);
  const Entries<const Real3> v = fluid.particles.velocity, boundary = fluid.boundary_gradient,
                             sheet = fluid.contact.gradient;
  const DensityOperator divergence = system.divergence(std::as_const(system.work).position_kappa, {});
  const Entries<Real4> predicted = system.work.predicted;
  const Entries<const Real> contact = std::as_const(system.work).contact_pressure;
  const Entries<const Real3> diagonal = fluid.wall_gain.diagonal, shear = fluid.wall_gain.shear;
  const Entries<const Index> walls = system.lists.fluid_boundary.count;
  const bool bounded = system.bodies.boundary.count > 0 || system.has_cloth(), touching = system.touching,
             extrapolates = system.constants.model.extrapolates_walls();
  const auto row = KOKKOS_LAMBDA(const Index i) {
    const Real ki = divergence.position(i).w;
    Real3 a = -divergence.gradient(i);
    if (bounded) a -= ki * boundary(i);
    if (touching) a -= contact(i) * sheet(i);
    if (extrapolates && walls(i) > 0) a = product(diagonal(i), shear(i), a);
    predicted(i) = {v(i) + dt * a, ki};
  };
  constexpr const char* label = "drench::pressure::acceleration";
  fluid.exchange.inner_rows(label, system.count(), row);
  take_kappa(system);
  fluid.exchange.outer_rows(label, system.count(), row);
  fluid.exchange.begin_halo(system.work.predicted);
}

namespace {

/// Dynamic bodies get the reaction that they owe the liquid's predicted change of velocity; at the end of a solve what
/// the start has not given.
void push_bodies(PressureSystem& system, bool ends) {
  if (!has_wall_push(system.constants, system.bodies)) return;
  const Entries<Real3> push = room_for_wall_push(system.fluid);
  const Entries<const Real3> v = std::as_const(system.fluid).particles.velocity;
  const Entries<const Real4> predicted = std::as_const(system.work).predicted;
  parallel(
      "drench::pressure::wall_push", system.count(),
      KOKKOS_LAMBDA(const Index i) { push(i) = predicted(i).xyz() - v(i); });
  if (ends)
    push_bodies_further(system.constants, system.lists, system.fluid, system.bodies, system.work.bodies_ahead);
  else
    push_bodies_ahead(system.constants, system.lists, system.fluid, system.bodies, system.work.bodies_ahead);
}

}  // namespace

void apply_pressure(PressureSystem& system) {
  if constexpr (has_lean_pressure)
    if (system.lean) predict_lean_liquid(system);
  if (!system.lean) predict_liquid(system);
  if (system.starts) push_bodies(system, false);
  system.starts = false;
  if (system.has_cloth()) {
    const SheetLoad load{system.lists.sheet_rows, system.fluid.exchange, system.kappa,
                         system.touching ? &system.work.contact_pressure : nullptr};
    if (system.elastic) {
      load_elastic_cloth(load, system.cloth, system.elastic->targets());
      system.elastic->respond();
    } else {
      load_free_cloth(load, system.cloth, Real(system.dt));
    }
  }
  predict_bodies(system.constants, system.fluid, system.lists, system.kappa, system.dt, system.bodies);
  if (system.lean) return;  // its update finds the rates itself
  if (system.keep_liquid_rate)
    make_room(system.work.liquid_rate, "drench::pressure::liquid_rate", system.fluid.particles.capacity());
  measure_density_rate(system);
}

double mean_source(PressureSystem& system, const DensityUpdate& update) {
  measure_free_rate(system);
  const Entries<const Real> rate = std::as_const(system.work).free_rate;
  const ErrorScale scale(system.all(), 1);
  const auto source = KOKKOS_LAMBDA(const Index i) {
    return scale(larger(update.residual(i, update.weight(i), update.touch(i), rate(i)), Real(0)));
  };
  std::int64_t sum = ordered<std::int64_t>("drench::pressure::source", system.count(), source);
  OverRanks(system.constants.ranks).sum(sum).reduce();
  return scale.value(sum) / system.all();
}

SumUnderWay<DensitySums> begin_full_update(const PressureSystem& system, const DensityUpdate& update, int slot) {
  const Entries<const Real> rate = std::as_const(system.work).density_rate,
                            approach = std::as_const(system.work).approach_rate;
  const bool touching = system.touching;
  return begin_ordered<DensitySums>(
      "drench::pressure::residual", system.count(),
      KOKKOS_LAMBDA(const Index i) { return update.exact(update(i, rate(i), touching ? approach(i) : Real(0))); },
      slot);
}

SumUnderWay<IterationNorms> begin_full_update(const PressureSystem& system, const DivergenceUpdate& update, int slot) {
  const Entries<const Real> rate = std::as_const(system.work).density_rate;
  return begin_ordered<IterationNorms>(
      "drench::divergence::error", system.count(),
      KOKKOS_LAMBDA(const Index i) { return update.exact(update(i, rate(i), Real(0))); }, slot);
}

void accept_pressure(PressureSystem& system) {
  if constexpr (has_lean_pressure)
    if (system.lean) finish_lean_pressure(system);
  body_stage(system.bodies, 0, system.dt, nullptr);
  push_bodies(system, true);
  const Entries<Real3> v = system.fluid.particles.velocity;
  const Entries<const Real4> predicted = std::as_const(system.work).predicted;
  parallel(
      "drench::pressure::accept", system.count(), KOKKOS_LAMBDA(const Index i) { v(i) = predicted(i).xyz(); });
  if (!system.has_cloth()) return;
  if (system.elastic)
    system.elastic->accept();
  else
    accept_free_cloth(system.cloth);
}

void PressureIteration::start() {
  PressureWork& work = system_.work;
  const Entries<Real> kappa = system_.kappa, last = work.last_kappa, contact = work.contact_pressure,
                      last_contact = work.last_contact_pressure;
  const Entries<Real4> position_kappa = work.position_kappa;
  const Entries<const Real4> position = std::as_const(system_.fluid).position_volume;
  const bool touching = system_.touching;
  parallel(
      "drench::pressure::start", system_.fluid.particles.local(), KOKKOS_LAMBDA(const Index i) {
        last(i) = kappa(i);
        position_kappa(i) = {position(i).xyz(), kappa(i)};
        if (touching) contact(i) = last_contact(i) = 0;
      });
}

double PressureIteration::next(double weight) { return 0.5 * (1 + std::sqrt(1 + 4 * weight * weight)); }

Real PressureIteration::momentum() const { return Real((weight_ - 1) / next(weight_)); }

void PressureIteration::advance(double residual, double restart, bool stepped) {
  if (residual > most_growth * smallest_) {
    relaxation_ *= Real(0.5);
    smallest_ = residual;
  }
  smallest_ = std::min(residual, smallest_);
  const bool restarts = residual > last_ || restart > 0;
  last_ = residual;
  const bool differs = restarts && weight_ > 1;
  if (restarts) weight_ = 1;
  if (!stepped) return step();
  weight_ = next(weight_);
  take_step(differs);
}

void PressureIteration::step() {
  const Real weight = momentum();
  weight_ = next(weight_);
  PressureWork& work = system_.work;
  const Entries<Real> kappa = system_.kappa, contact = work.contact_pressure;
  const Entries<const Real> next = std::as_const(work).next_kappa, last = std::as_const(work).last_kappa,
                            next_contact = std::as_const(work).next_contact_pressure,
                            last_contact = std::as_const(work).last_contact_pressure;
  const Entries<const Real4> base = std::as_const(work).predicted;
  const Entries<Real4> position_kappa = work.position_kappa;
  const bool touching = system_.touching, lean = system_.lean;
  parallel(
      "drench::pressure::update", system_.count(), KOKKOS_LAMBDA(const Index i) {
        const Real y = next(i) + weight * (next(i) - last(i)), k = y > 0 ? y : Real(0);
        kappa(i) = k;
        position_kappa(i).w = lean ? k - base(i).w : k;
        if (!touching) return;
        const Real c = next_contact(i) + weight * (next_contact(i) - last_contact(i));
        contact(i) = c > 0 ? c : Real(0);
      });
  std::swap(work.next_kappa, work.last_kappa);
  std::swap(work.next_contact_pressure, work.last_contact_pressure);
}

void PressureIteration::take_step(bool restarts) {
  PressureWork& work = system_.work;
  std::swap(work.next_kappa, work.last_kappa);
  std::swap(work.next_contact_pressure, work.last_contact_pressure);
  std::swap(system_.kappa, work.other_kappa);
  std::swap(work.contact_pressure, work.other_contact_pressure);
  if (!restarts) return;
  const Entries<Real> kappa = system_.kappa, contact = work.contact_pressure;
  const Entries<const Real> last = std::as_const(work).last_kappa,
                            last_contact = std::as_const(work).last_contact_pressure;
  const Entries<const Real4> base = std::as_const(work).predicted;
  const Entries<Real4> position_kappa = work.position_kappa;
  const bool touching = system_.touching;
  parallel(
      "drench::pressure::restart", system_.count(), KOKKOS_LAMBDA(const Index i) {
        kappa(i) = last(i);
        position_kappa(i).w = last(i) - base(i).w;
        if (touching) contact(i) = last_contact(i);
      });
}

}  // namespace drench::kokkos_backend
