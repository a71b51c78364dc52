// Stage forces (src/stages/forces.hpp).

#include "device.hpp"
#include "laws/viscosity.hpp"
#include "rigid_bodies.hpp"

namespace drench::kokkos_backend {
namespace {

KOKKOS_INLINE_FUNCTION Real bounded_ratio(Real delta) { return delta < Real(0.5) ? Real(0.5) : delta; }

/// Viscous reaction of the liquid on the cloth, from the velocities before the stage.
void viscous_reaction(Device& d, Real dt) {
  const Kernel kernel = d.kernel;
  const Real nu = Real(d.model.scene.fluid.viscosity), h = d.support, rho = d.rest_density;
  const auto xs = d.samples.position, xf = d.fluid.position, us = d.samples.velocity, v = d.fluid.velocity;
  const auto force = d.samples.force;
  const auto vs = d.samples.volume, volume = d.work.volume, ratio = d.fluid.density_ratio;
  const auto count = d.sample_fluid.count;
  const auto list = d.sample_fluid.list;
  parallel(
      "drench::forces::sample_force", d.samples.count, KOKKOS_LAMBDA(const Index b) {
        Real3 f;
        for (Index k = 0; k < count(b); ++k) {
          const Index i = list(b, k);
          const Real3 r = xf(i) - xs(b);
          const Real r2 = dot(r, r);
          const Real factor = viscous_factor(nu, vs(b) / bounded_ratio(ratio(i)), dot(v(i) - us(b), r), r2, h) *
                              kernel.slope(Kokkos::sqrt(r2));
          f -= rho * volume(i) * factor * r;
        }
        force(b) = f;
      });
  node_forces_from_samples(d);
  apply_node_forces(d, dt);
}

}  // namespace

void forces(Device& d, const StepInfo& info, StepReport&) {
  const Kernel kernel = d.kernel;
  const Real nu = Real(d.model.scene.fluid.viscosity), h = d.support, dt = Real(info.dt);
  const Real3 g = d.gravity;
  const bool solids = d.boundary.count > 0, cloth = d.samples.count > 0;
  if (cloth) {
    refresh_samples(d);  // the divergence solve has changed the nodes' velocities
    refresh_inverse_mass(d);
  }
  const auto x = d.fluid.position, xb = d.boundary.position, xs = d.samples.position;
  const auto v = d.fluid.velocity, ub = d.boundary.velocity, us = d.samples.velocity, predicted = d.work.predicted;
  const auto volume = d.work.volume, vb = d.boundary.volume, vs = d.samples.volume, ratio = d.fluid.density_ratio;
  const auto nf = d.fluid_fluid.count, nb = d.fluid_boundary.count, ns = d.fluid_sample.count;
  const auto lf = d.fluid_fluid.list, lb = d.fluid_boundary.list, ls = d.fluid_sample.list;
  const bool viscous = nu > 0;
  parallel(
      "drench::forces::acceleration", d.fluid.count, KOKKOS_LAMBDA(const Index i) {
        Real3 a = g;
        if (viscous) {
          const Real3 xi = x(i), vi = v(i);
          const Real di = bounded_ratio(ratio(i));
          for (Index k = 0; k < nf(i); ++k) {
            const Index j = lf(i, k);
            const Real3 r = xi - x(j);
            const Real r2 = dot(r, r), mean = Real(0.5) * (di + bounded_ratio(ratio(j)));
            a += viscous_factor(nu, volume(j) / mean, dot(vi - v(j), r), r2, h) * kernel.slope(Kokkos::sqrt(r2)) * r;
          }
          if (solids)
            for (Index k = 0; k < nb(i); ++k) {
              const Index b = lb(i, k);
              const Real3 r = xi - xb(b);
              const Real r2 = dot(r, r);
              a += viscous_factor(nu, vb(b) / di, dot(vi - ub(b), r), r2, h) * kernel.slope(Kokkos::sqrt(r2)) * r;
            }
          if (cloth)
            for (Index k = 0; k < ns(i); ++k) {
              const Index b = ls(i, k);
              const Real3 r = xi - xs(b);
              const Real r2 = dot(r, r);
              a += viscous_factor(nu, vs(b) / di, dot(vi - us(b), r), r2, h) * kernel.slope(Kokkos::sqrt(r2)) * r;
            }
        }
        predicted(i) = v(i) + dt * a;
      });
  if (viscous && cloth) viscous_reaction(d, dt);
  push_bodies(d, info.dt);
  parallel(
      "drench::forces::velocity", d.fluid.count, KOKKOS_LAMBDA(const Index i) { v(i) = predicted(i); });
}

}  // namespace drench::kokkos_backend
