// Stage forces (src/stages/forces.hpp).

#include <algorithm>

#include "device.hpp"
#include "laws/runge_kutta_legendre.hpp"
#include "laws/viscosity.hpp"
#include "primitives/reduce.hpp"
#include "rigid_bodies.hpp"

namespace drench::kokkos_backend {
namespace {

/// Gravity and the field alone.
void inviscid(Device& d, Real dt) {
  const Real3 g = d.gravity, center = d.field_center, square = d.field_square;
  const bool field = d.model.scene.field.present;
  const auto x = d.fluid.position, v = d.fluid.velocity;
  parallel(
      "drench::forces::velocity", d.fluid.count,
      KOKKOS_LAMBDA(const Index i) { v(i) += dt * (field ? g + central_field(x(i), center, square) : g); });
}

/// δ_i as the viscosity counts it.
KOKKOS_INLINE_FUNCTION Real bounded_ratio(Real delta) { return delta < Real(0.5) ? Real(0.5) : delta; }

/// v_i and 1/√δ_i in work.flight: with these shares the pairs' mean costs nothing.
void pair_shares(Device& d) {
  if (d.work.flight.extent(0) != d.fluid.position.extent(0)) {
    d.work.flight = {};  // free before allocating
    d.work.flight =
        Array<Real4>(Kokkos::ViewAllocateWithoutInitializing("drench::fluid_flight"), d.fluid.position.extent(0));
  }
  const auto ratio = d.fluid.density_ratio;
  const auto v = d.fluid.velocity;
  const auto flight = d.work.flight;
  parallel(
      "drench::forces::pair_share", d.fluid.count, KOKKOS_LAMBDA(const Index i) {
        flight(i) = {v(i), 1 / Kokkos::sqrt(bounded_ratio(ratio(i)))};
      });
}

/// The liquid's change in a stage, in work.predicted, and C_i, 1/s, in work.rate.
void liquid_change(const Device& d, const LegendreStage& stage) {
  const Kernel kernel = d.kernel;
  const Real strength = d.viscous_strength;
  const Real3 g = d.gravity, center = d.field_center, square = d.field_square;
  const bool field = d.model.scene.field.present;
  const bool solids = d.boundary.count > 0, cloth = d.samples.count > 0;
  const Entries<Real3> xb = d.boundary.position, ub = d.boundary.velocity, us = d.samples.velocity;
  const Entries<Real4> place = d.work.place, flight = d.work.flight, change = d.work.predicted, xs = d.samples.place;
  const Entries<Real> vb = d.boundary.volume, bound = d.work.rate;
  const Neighbors lf = d.fluid_fluid, lb = d.fluid_boundary, ls = d.fluid_sample;
  // The bounds by themselves: a reduction's blocks have fewer threads at once than the neighbours' loads need.
  parallel(
      "drench::forces::liquid", d.fluid.count, KOKKOS_LAMBDA(const Index i) {
        const Real3 xi = place(i).xyz(), vi = flight(i).xyz();
        const Real share = flight(i).w;
        ViscousSum sum;
        const NeighborRow near = lf.row(i);
        DRENCH_UNROLL
        for (Index k = 0; k < near.count; ++k) {
          const Index j = near(k);
          const Real4 other = flight(j);
          const Real3 r = xi - place(j).xyz();
          sum.add(other.w, vi - other.xyz(), r, near.slope(k) * r);
        }
        if (solids) {
          const NeighborRow walls = lb.row(i);
          for (Index k = 0; k < walls.count; ++k) {
            const Index b = walls(k);
            const Real3 r = xi - xb(b);
            sum.add(solid_friction * share * vb(b), vi - ub(b), r, kernel.gradient(r));
          }
        }
        if (cloth) {
          const NeighborRow sheets = ls.row(i);
          for (Index k = 0; k < sheets.count; ++k) {
            const Index b = sheets(k);
            const Real4 at = xs(b);
            const Real3 r = xi - at.xyz();
            sum.add(sheet_friction * share * at.w, vi - us(b), r, kernel.gradient(r));
          }
        }
        Real3 rate = g + (strength * share) * sum.pull;
        if (field) rate += central_field(xi, center, square);
        Real3 next = stage.weight * rate;
        if (stage.keep != 0) next += stage.keep * change(i).xyz();
        change(i) = {next, Real(0)};
        bound(i) = strength * share * sum.bound;
      });
}

/// Adds the largest C_i, 1/s.
void find_liquid_bound(const Device& d, MaximaUnderWay& maxima) {
  const auto bound = d.work.rate;
  maxima.add(
      "drench::forces::bound", d.fluid.count, KOKKOS_LAMBDA(const Index i) { return double(bound(i)); });
}

void add_change(const Device& d) {
  const auto v = d.fluid.velocity;
  const auto flight = d.work.flight, change = d.work.predicted;
  parallel(
      "drench::forces::velocity", d.fluid.count, KOKKOS_LAMBDA(const Index i) {
        v(i) += change(i).xyz();
        flight(i) = {v(i), flight(i).w};
      });
}

/// The reaction on samples and nodes (d.nodes.force).
void cloth_forces(Device& d) {
  if (d.viscous_work.sample_bound.extent(0) == 0)
    d.viscous_work.sample_bound = Array<Real>("drench::viscous_sample_bound", d.samples.count);
  const Kernel kernel = d.kernel;
  const Real strength = sheet_friction * d.viscous_strength * d.rest_density;
  const Entries<Real3> xs = d.samples.position, xf = d.fluid.position, us = d.samples.velocity, v = d.fluid.velocity,
                       force = d.samples.force;
  const Entries<Real> vs = d.samples.volume, volume = d.work.volume, ratio = d.fluid.density_ratio,
                      bound = d.viscous_work.sample_bound;
  const Neighbors list(d.sample_fluid);
  parallel(
      "drench::forces::sample_force", d.samples.count, KOKKOS_LAMBDA(const Index b) {
        ViscousSum sum;
        const Real3 here = xs(b), moves = us(b);
        const NeighborRow near = list.row(b);
        DRENCH_UNROLL
        for (Index k = 0; k < near.count; ++k) {
          const Index i = near(k);
          const Real3 r = here - xf(i);
          sum.add(volume(i) / bounded_ratio(ratio(i)), moves - v(i), r, kernel.gradient(r));
        }
        force(b) = (strength * vs(b)) * sum.pull;
        bound(b) = strength * vs(b) * sum.bound;
      });
  node_forces_from_samples(d);
}

/// Adds the largest u_n Σ_b w_bn K_b, 1/s.
void find_node_bound(const Device& d, MaximaUnderWay& maxima) {
  node_bounds_from_samples("drench::forces::node_row", d, d.viscous_work.sample_bound);
  const auto node_bound = d.nodes.row_bound;
  maxima.add(
      "drench::forces::node_bound", d.nodes.count, KOKKOS_LAMBDA(const Index n) { return double(node_bound(n)); });
}

/// A stage of the nodes: their impulse J grows by its own D_k.
void node_stage(Device& d, const LegendreStage& stage, Real dt) {
  const auto change = d.viscous_work.impulse_change, v = d.nodes.velocity, f = d.nodes.force, pin = d.nodes.pin_force;
  const auto u = d.nodes.inverse_mass;
  const auto pinned = d.nodes.pinned;
  parallel(
      "drench::forces::node_stage", d.nodes.count, KOKKOS_LAMBDA(const Index n) {
        const Real3 next = stage.keep * change(n) + stage.weight * f(n);
        change(n) = next;
        if (pinned(n))
          pin(n) -= (1 / dt) * next;
        else
          v(n) += u(n) * next;
      });
}

/// All stages, the forces of the first being there and its change made with the whole Δt.
void many_stages(Device& d, int stages, double dt) {
  const bool cloth = d.samples.count > 0;
  const auto change = d.work.predicted;
  const Real share = Real(2 / (double(stages) * (stages + 1.0)));
  parallel(
      "drench::forces::first_stage", d.fluid.count, KOKKOS_LAMBDA(const Index i) {
        change(i) = {share * change(i).xyz(), Real(0)};
      });
  if (cloth && d.viscous_work.impulse_change.extent(0) == 0)
    d.viscous_work.impulse_change = Array<Real3>("drench::viscous_impulse_change", d.nodes.count);
  for (int k = 1; k <= stages; ++k) {
    const LegendreStage stage = legendre(k, stages, dt);
    if (k > 1) {
      viscous_body_forces(d);
      if (cloth) {
        refresh_samples(d);
        cloth_forces(d);
      }
      liquid_change(d, stage);
    }
    add_change(d);
    if (cloth) node_stage(d, stage, Real(dt));
    body_stage(d, double(stage.keep), double(stage.weight), true);
  }
}

}  // namespace

void forces(Device& d, const StepInfo& info, StepReport&) {
  if (d.viscous_strength == 0) {
    viscous_body_forces(d);  // none
    body_stage(d, 0, info.dt, true);
    inviscid(d, Real(info.dt));
    return;
  }
  const bool cloth = d.samples.count > 0;
  pair_shares(d);
  if (cloth) {
    refresh_samples(d);  // the divergence solve has changed the nodes' velocities
    refresh_inverse_mass(d);
    cloth_forces(d);
  }
  viscous_body_forces(d);
  liquid_change(d, legendre(1, 1, info.dt));
  MaximaUnderWay maxima;
  find_liquid_bound(d, maxima);
  if (cloth) find_node_bound(d, maxima);
  find_viscous_body_bound(d, maxima);
  const double bound = maxima.wait("drench::forces::bound");
  int stages = 1;
  while (stages * (stages + 1.0) < 2 * info.dt * bound) ++stages;
  if (stages > 1) {
    many_stages(d, stages, info.dt);
    return;
  }
  add_change(d);
  if (cloth) apply_node_forces(d, Real(info.dt));
  body_stage(d, 0, info.dt, true);
}

}  // namespace drench::kokkos_backend
