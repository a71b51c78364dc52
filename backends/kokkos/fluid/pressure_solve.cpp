#include "fluid/pressure_solve.hpp"

#include <algorithm>
#include <cmath>

#include "coupling/body_response.hpp"
#include "coupling/wall.hpp"

namespace drench::kokkos_backend {
namespace {

/// work.predicted = v_i + Δt a_i(κ, λ) and the load on sheets.
void predict_liquid(PressureSystem& system) {
  const Fluid& fluid = system.fluid;
  const Real dt = Real(system.dt);
  const Entries<const Real3> v = fluid.particles.velocity, xb = system.bodies.boundary.position,
                             gradient = system.lists.fluid_sample.gradient;
  const Entries<const Real4> position_kappa = std::as_const(system.work).position_kappa;
  const Entries<Real4> predicted = system.work.predicted;
  const Entries<const Real> ratio = fluid.particles.density_ratio, volume = fluid.volume,
                            contact = std::as_const(system.work).contact_pressure;
  const Neighbors lf(system.lists.fluid_fluid), lb(system.lists.fluid_boundary), ls(system.lists.fluid_sample);
  const bool solids = system.bodies.boundary.count > 0, cloth = system.has_cloth(), touching = system.touching;
  parallel(
      "drench::pressure::acceleration", system.count(), KOKKOS_LAMBDA(const Index i) {
        const Real4 here = position_kappa(i);
        const Real3 xi = here.xyz();
        const Real ki = here.w;
        Real3 a;
        const NeighborRow near = lf.row(i);
        DRENCH_UNROLL
        for (Index k = 0; k < near.count; ++k) {
          const Real4 at = position_kappa(near(k));
          a -= (near.grad_factor(k) * (ki + at.w)) * (xi - at.xyz());
        }
        const Real at_sheet = touching ? ki + contact(i) : ki;
        if (at_sheet != 0) {
          if (solids) {
            const NeighborRow walls = lb.row(i);
            for (Index k = 0; k < walls.count; ++k) a -= (mirrored * ki * walls.grad_factor(k)) * (xi - xb(walls(k)));
          }
          if (cloth) {
            const Real dense = image_density(ratio(i)) * mirrored * at_sheet;
            const NeighborRow sheets = ls.row(i);
            DRENCH_UNROLL
            for (Index k = 0; k < sheets.count; ++k) a -= dense * gradient(sheets.index_of(k));
          }
        }
        predicted(i) = {v(i) + dt * a, cloth ? sheet_load(ratio(i), volume(i), at_sheet) : Real(0)};
      });
}

/// work.density_rate = R_i of the predicted velocities − Δt C_i κ_i, 1/s; touching sheets: work.approach_rate = R'_i too.
void measure_density_rate(PressureSystem& system) {
  const Fluid& fluid = system.fluid;
  const Bodies& bodies = system.bodies;
  const Real dt = Real(system.dt);
  const PressureWork& work = system.work;
  const Entries<const Real3> ub = bodies.seen_velocity(), xb = bodies.boundary.position,
                             gradient = system.lists.fluid_sample.gradient;
  const Entries<const Real4> position_kappa = work.position_kappa, v = work.predicted,
                             us = std::as_const(system.cloth).samples.predicted;
  const Entries<const Real> compliance = fluid.compliance,
                            ratio = fluid.particles.density_ratio, kappa = std::as_const(system.kappa);
  const Entries<Real> rate = system.work.density_rate, approach = system.work.approach_rate;
  const Neighbors lf(system.lists.fluid_fluid), lb(system.lists.fluid_boundary), ls(system.lists.fluid_sample);
  const bool solids = bodies.boundary.count > 0, cloth = system.has_cloth(), touching = system.touching;
  parallel(
      "drench::pressure::density_rate", system.count(), KOKKOS_LAMBDA(const Index i) {
        const Real3 xi = position_kappa(i).xyz(), vi = v(i).xyz();
        Real sum = 0;
        const NeighborRow near = lf.row(i);
        DRENCH_UNROLL
        for (Index k = 0; k < near.count; ++k) {
          const Index j = near(k);
          sum += near.grad_factor(k) * dot(vi - v(j).xyz(), xi - position_kappa(j).xyz());
        }
        if (solids) {
          const NeighborRow walls = lb.row(i);
          for (Index k = 0; k < walls.count; ++k) {
            const Index b = walls(k);
            sum += mirrored * walls.grad_factor(k) * dot(vi - ub(b), xi - xb(b));
          }
        }
        if (cloth) {
          Real sheet = 0;
          const NeighborRow sheets = ls.row(i);
          DRENCH_UNROLL
          for (Index k = 0; k < sheets.count; ++k) sheet += dot(vi - us(sheets(k)).xyz(), gradient(sheets.index_of(k)));
          sheet *= mirrored * image_density(ratio(i));
          if (touching) approach(i) = sheet;
          sum += sheet;
        }
        rate(i) = sum - dt * compliance(i) * kappa(i);
      });
}

}  // namespace

void apply_pressure(PressureSystem& system) {
  const Real dt = Real(system.dt);
  predict_liquid(system);
  if (system.has_cloth()) {
    load_cloth(system.constants, system.fluid, system.lists, system.work, system.cloth);
    if (system.elastic)
      system.elastic->respond();
    else
      predict_free_cloth(system.cloth, dt);
  }
  predict_bodies(system.constants, system.fluid, system.lists, system.kappa, system.dt, system.bodies);
  measure_density_rate(system);
}

void accept_pressure(PressureSystem& system) {
  const Entries<Real3> v = system.fluid.particles.velocity;
  const Entries<const Real4> predicted = std::as_const(system.work).predicted;
  parallel(
      "drench::pressure::accept", system.count(), KOKKOS_LAMBDA(const Index i) { v(i) = predicted(i).xyz(); });
  body_stage(system.bodies, 0, system.dt, Real3{});
  if (!system.has_cloth()) return;
  if (system.elastic)
    system.elastic->accept();
  else
    accept_free_cloth(system.cloth, Real(system.dt));
}

void PressureIteration::start() {
  PressureWork& work = system_.work;
  const Entries<Real> kappa = system_.kappa, last = work.last_kappa, contact = work.contact_pressure,
                      last_contact = work.last_contact_pressure;
  const Entries<Real4> position_kappa = work.position_kappa;
  const Entries<const Real4> position = std::as_const(system_.fluid).position_volume;
  const bool touching = system_.touching;
  parallel(
      "drench::pressure::start", system_.count(), KOKKOS_LAMBDA(const Index i) {
        last(i) = kappa(i);
        position_kappa(i) = {position(i).xyz(), kappa(i)};
        if (touching) contact(i) = last_contact(i) = 0;
      });
}

void PressureIteration::advance(double residual, double restart) {
  if (residual > most_growth * smallest_) {
    relaxation_ *= Real(0.5);
    smallest_ = residual;
  }
  smallest_ = std::min(residual, smallest_);
  if (residual > last_ || restart > 0) weight_ = 1;
  last_ = residual;
  move_on();
}

void PressureIteration::move_on() {
  const double next_weight = 0.5 * (1 + std::sqrt(1 + 4 * weight_ * weight_));
  const Real momentum = Real((weight_ - 1) / next_weight);
  weight_ = next_weight;
  PressureWork& work = system_.work;
  const Entries<Real> kappa = system_.kappa, next = work.next_kappa, last = work.last_kappa,
                      contact = work.contact_pressure, next_contact = work.next_contact_pressure,
                      last_contact = work.last_contact_pressure;
  const Entries<Real4> position_kappa = work.position_kappa;
  const bool touching = system_.touching;
  parallel(
      "drench::pressure::update", system_.count(), KOKKOS_LAMBDA(const Index i) {
        const Real k = next(i) + momentum * (next(i) - last(i));
        last(i) = next(i);
        position_kappa(i).w = kappa(i) = k > 0 ? k : Real(0);
        if (!touching) return;
        const Real c = next_contact(i) + momentum * (next_contact(i) - last_contact(i));
        last_contact(i) = next_contact(i);
        contact(i) = c > 0 ? c : Real(0);
      });
}

}  // namespace drench::kokkos_backend
