// Stage forces (src/stages/forces.hpp).

#include <algorithm>
#include <utility>

#include "device.hpp"
#include "laws/viscosity.hpp"
#include "primitives/reduce.hpp"

namespace drench::kokkos_backend {
namespace {

/// Y_k = mu Y_{k−1} + nu Y_{k−2} + weight L(Y_{k−1}); weight in s.
struct Stage {
  Real mu = 1, nu = 0, weight = 0;
};

/// The k-th of `count` stages of RKL1 over dt (s).
Stage legendre(int k, int count, double dt) {
  const double mu = (2 * k - 1.0) / k;
  return {Real(mu), Real((1.0 - k) / k), Real(mu * dt * 2 / (double(count) * (count + 1.0)))};
}

/// Gravity and the field alone.
void inviscid(Device& d, Real dt) {
  const Real3 g = d.gravity, center = d.field_center, square = d.field_square;
  const bool field = d.model.scene.field.present;
  const auto x = d.fluid.position, v = d.fluid.velocity;
  parallel(
      "drench::forces::velocity", d.fluid.count, KOKKOS_LAMBDA(const Index i) {
        v(i) += dt * (field ? g + central_field(x(i), center, square) : g);
      });
}

/// A stage of the liquid, `to` holding Y_{k−2} before and Y_k after. Returns the largest C_i, 1/s.
double liquid_stage(const Device& d, const Stage& stage, const Array<Real3>& from, const Array<Real3>& to) {
  const Kernel kernel = d.kernel;
  const Real strength = d.viscous_strength;
  const Real3 g = d.gravity, center = d.field_center, square = d.field_square;
  const bool field = d.model.scene.field.present;
  const bool solids = d.boundary.count > 0, cloth = d.samples.count > 0;
  const auto x = d.fluid.position, xb = d.boundary.position, xs = d.samples.position;
  const auto ub = d.boundary.velocity, us = d.samples.velocity;
  const auto volume = d.work.volume, vb = d.boundary.volume, vs = d.samples.volume;
  const auto nf = d.fluid_fluid.count, nb = d.fluid_boundary.count, ns = d.fluid_sample.count;
  const auto lf = d.fluid_fluid.list, lb = d.fluid_boundary.list, ls = d.fluid_sample.list;
  return maximum(
      "drench::forces::liquid", d.fluid.count, KOKKOS_LAMBDA(const Index i) {
        const Real3 xi = x(i), vi = from(i);
        ViscousSum sum;
        for (Index k = 0; k < nf(i); ++k) {
          const Index j = lf(i, k);
          const Real3 r = xi - x(j);
          const Real r2 = dot(r, r);
          sum.add(volume(j), vi - from(j), r, r2, kernel.slope(Kokkos::sqrt(r2)));
        }
        if (solids)
          for (Index k = 0; k < nb(i); ++k) {
            const Index b = lb(i, k);
            const Real3 r = xi - xb(b);
            const Real r2 = dot(r, r);
            sum.add(solid_friction * vb(b), vi - ub(b), r, r2, kernel.slope(Kokkos::sqrt(r2)));
          }
        if (cloth)
          for (Index k = 0; k < ns(i); ++k) {
            const Index b = ls(i, k);
            const Real3 r = xi - xs(b);
            const Real r2 = dot(r, r);
            sum.add(sheet_friction * vs(b), vi - us(b), r, r2, kernel.slope(Kokkos::sqrt(r2)));
          }
        Real3 rate = g + strength * sum.pull;
        if (field) rate += central_field(xi, center, square);
        Real3 next = stage.mu * vi + stage.weight * rate;
        if (stage.nu != 0) next += stage.nu * to(i);
        to(i) = next;
        return double(strength * sum.bound);
      });
}

/// The reaction on samples and nodes (d.nodes.force) of liquid that moves with `v`.
void cloth_forces(Device& d, const Array<Real3>& v) {
  if (d.viscous_work.sample_bound.extent(0) == 0)
    d.viscous_work.sample_bound = Array<Real>("drench::viscous_sample_bound", d.samples.count);
  const Kernel kernel = d.kernel;
  const Real strength = sheet_friction * d.viscous_strength * d.rest_density;
  const auto xs = d.samples.position, xf = d.fluid.position, us = d.samples.velocity;
  const auto force = d.samples.force;
  const auto vs = d.samples.volume, volume = d.work.volume, bound = d.viscous_work.sample_bound;
  const auto count = d.sample_fluid.count;
  const auto list = d.sample_fluid.list;
  parallel(
      "drench::forces::sample_force", d.samples.count, KOKKOS_LAMBDA(const Index b) {
        ViscousSum sum;
        for (Index k = 0; k < count(b); ++k) {
          const Index i = list(b, k);
          const Real3 r = xs(b) - xf(i);
          const Real r2 = dot(r, r);
          sum.add(volume(i), us(b) - v(i), r, r2, kernel.slope(Kokkos::sqrt(r2)));
        }
        force(b) = (strength * vs(b)) * sum.pull;
        bound(b) = strength * vs(b) * sum.bound;
      });
  node_forces_from_samples(d);
}

/// The largest u_n Σ_b w_bn K_b, 1/s.
double node_bound(const Device& d) {
  const auto start = d.nodes.sample_start, item = d.nodes.sample_item;
  const auto weight = d.samples.weight, u = d.nodes.inverse_mass, bound = d.viscous_work.sample_bound;
  return maximum(
      "drench::forces::node_bound", d.nodes.count, KOKKOS_LAMBDA(const Index n) {
        Real sum = 0;
        for (Index e = start(n); e < start(n + 1); ++e)
          sum += weight(3 * (item(e) / 4) + item(e) % 4) * bound(item(e) / 4);
        return double(u(n) * sum);
      });
}

/// J_k of the nodes into `to`, and their velocities to match.
void node_stage(Device& d, const Stage& stage, const Array<Real3>& from, const Array<Real3>& to) {
  const auto start = d.viscous_work.start, v = d.nodes.velocity, f = d.nodes.force;
  const auto u = d.nodes.inverse_mass;
  parallel(
      "drench::forces::node_stage", d.nodes.count, KOKKOS_LAMBDA(const Index n) {
        to(n) = stage.mu * from(n) + stage.nu * to(n) + stage.weight * f(n);
        v(n) = start(n) + u(n) * to(n);
      });
}

void pin_reaction(Device& d, const Array<Real3>& impulse, Real dt) {
  const auto pin = d.nodes.pin_force;
  const auto pinned = d.nodes.pinned;
  parallel(
      "drench::forces::pin", d.nodes.count, KOKKOS_LAMBDA(const Index n) {
        if (pinned(n)) pin(n) -= (1 / dt) * impulse(n);
      });
}

/// The stages after the first, which was made with the whole Δt and is shortened here.
void further_stages(Device& d, int stages, double dt) {
  const bool cloth = d.samples.count > 0;
  Array<Real3> last = d.fluid.velocity, now = d.work.predicted;
  const Real share = Real(2 / (double(stages) * (stages + 1.0)));
  parallel(
      "drench::forces::first_stage", d.fluid.count,
      KOKKOS_LAMBDA(const Index i) { now(i) = last(i) + share * (now(i) - last(i)); });
  ViscousWork& work = d.viscous_work;
  Array<Real3> impulse, last_impulse;
  if (cloth) {
    if (work.start.extent(0) == 0) {
      work.start = Array<Real3>("drench::viscous_start", d.nodes.count);
      work.impulse = Array<Real3>("drench::viscous_impulse", d.nodes.count);
      work.last_impulse = Array<Real3>("drench::viscous_last_impulse", d.nodes.count);
    }
    Kokkos::deep_copy(ExecSpace(), work.start, d.nodes.velocity);
    Kokkos::deep_copy(ExecSpace(), work.last_impulse, Real3{});
    impulse = work.last_impulse;
    last_impulse = work.impulse;
    node_stage(d, {0, 0, share * Real(dt)}, impulse, last_impulse);
    std::swap(impulse, last_impulse);
  }
  for (int k = 2; k <= stages; ++k) {
    const Stage stage = legendre(k, stages, dt);
    if (cloth) {
      refresh_samples(d);
      cloth_forces(d, now);
    }
    liquid_stage(d, stage, now, last);
    std::swap(now, last);
    if (!cloth) continue;
    node_stage(d, stage, impulse, last_impulse);
    std::swap(impulse, last_impulse);
  }
  if (cloth) pin_reaction(d, impulse, Real(dt));
  if (stages % 2 == 1) Kokkos::deep_copy(ExecSpace(), d.fluid.velocity, d.work.predicted);
}

}  // namespace

void forces(Device& d, const StepInfo& info, StepReport&) {
  if (d.viscous_strength == 0) {
    inviscid(d, Real(info.dt));
    return;
  }
  const bool cloth = d.samples.count > 0;
  if (cloth) {
    refresh_samples(d);  // the divergence solve has changed the nodes' velocities
    refresh_inverse_mass(d);
    cloth_forces(d, d.fluid.velocity);
  }
  double bound = liquid_stage(d, legendre(1, 1, info.dt), d.fluid.velocity, d.work.predicted);
  if (cloth) bound = std::max(bound, node_bound(d));
  int stages = 1;
  while (stages * (stages + 1.0) < 2 * info.dt * bound) ++stages;
  if (stages > 1) {
    further_stages(d, stages, info.dt);
    return;
  }
  if (cloth) apply_node_forces(d, Real(info.dt));
  const auto v = d.fluid.velocity, predicted = d.work.predicted;
  parallel(
      "drench::forces::velocity", d.fluid.count, KOKKOS_LAMBDA(const Index i) { v(i) = predicted(i); });
}

}  // namespace drench::kokkos_backend
