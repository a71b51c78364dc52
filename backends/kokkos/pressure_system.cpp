#include "pressure_system.hpp"

#include <algorithm>
#include <cmath>

#include "laws/wall.hpp"
#include "rigid_bodies.hpp"

namespace drench::kokkos_backend {
namespace {

/// A particle's thrust on the sheets near it, m⁵/s²: as dense as its image there, V_i κ_i (src/stages/divergence.hpp).
KOKKOS_INLINE_FUNCTION Real thrust(Real ratio, Real volume, Real kappa) {
  return image_density(ratio) * volume * kappa;
}

}  // namespace

void clear_inactive(Device& d) {
  const auto kappa = d.fluid.kappa_density, alpha = d.work.alpha, ratio = d.fluid.density_ratio, volume = d.work.volume;
  const auto predicted = d.work.predicted;
  const bool cloth = d.samples.count > 0;
  parallel(
      "drench::pressure::warm_start", d.fluid.count, KOKKOS_LAMBDA(const Index i) {
        if (alpha(i) == 0) kappa(i) = 0;
        if (cloth) predicted(i).w = thrust(ratio(i), volume(i), kappa(i));
      });
}

void PressureIteration::start() {
  const auto kappa = kappa_, last = device_.work.kappa_last;
  const auto place = device_.work.place;
  const auto push = device_.work.contact.push, push_last = device_.work.contact.last;
  const bool touching = touching_;
  parallel(
      "drench::pressure::start", device_.fluid.count, KOKKOS_LAMBDA(const Index i) {
        place(i).w = last(i) = kappa(i);
        if (touching) push(i) = push_last(i) = 0;
      });
}

void PressureIteration::advance(double residual, double against_momentum) {
  if (residual > most_growth * smallest_) {
    relaxation_ *= Real(0.5);
    smallest_ = residual;
  }
  smallest_ = std::min(residual, smallest_);
  if (residual > last_ || against_momentum > 0) weight_ = 1;
  last_ = residual;
  move_on();
}

void PressureIteration::move_on() {
  const double next_weight = 0.5 * (1 + std::sqrt(1 + 4 * weight_ * weight_));
  const Real momentum = Real((weight_ - 1) / next_weight);
  weight_ = next_weight;
  const auto kappa = kappa_, next = device_.work.kappa_next, last = device_.work.kappa_last;
  const auto place = device_.work.place;
  const SheetContact contact = device_.work.contact;
  const bool touching = touching_;
  parallel(
      "drench::pressure::update", device_.fluid.count, KOKKOS_LAMBDA(const Index i) {
        const Real k = next(i) + momentum * (next(i) - last(i));
        last(i) = next(i);
        place(i).w = kappa(i) = k > 0 ? k : Real(0);
        if (!touching) return;
        const Real c = contact.next(i) + momentum * (contact.next(i) - contact.last(i));
        contact.last(i) = contact.next(i);
        contact.push(i) = c > 0 ? c : Real(0);
      });
}

void cloth_forces(Device& d) {
  const Kernel kernel = d.kernel;
  const Real rho = d.rest_density;
  const Entries<Real4> xs = d.samples.place, back = d.samples.back, xf = d.work.place, predicted = d.work.predicted;
  const Entries<Real3> force = d.samples.force;
  const Neighbors list(d.sample_fluid);
  parallel(
      "drench::pressure::sample_force", d.samples.count, KOKKOS_LAMBDA(const Index b) {
        Real3 f;
        const Real4 at = xs(b);
        const Real3 behind = back(b).xyz();
        const NeighborRow near = list.row(b);
        DRENCH_UNROLL
        for (Index k = 0; k < near.count; ++k) {
          const Index i = near(k);
          const Real push = predicted(i).w;
          if (on_host && push == 0) continue;  // a GPU is quicker without a branch between the loads
          f += push * kernel.gradient(from_behind(xf(i).xyz() - at.xyz(), behind));
        }
        force(b) = (mirrored * rho * at.w) * f;
      });
  node_forces_from_samples(d);
}

void free_cloth_response(Device& d, Real dt) {
  const auto f = d.nodes.force, a = d.nodes.acceleration, contact = d.nodes.contact_force;
  const auto u = d.nodes.inverse_mass;
  parallel(
      "drench::pressure::node_acceleration", d.nodes.count, KOKKOS_LAMBDA(const Index n) {
        const Real square = dot(contact(n), contact(n)), into = dot(f(n), contact(n));
        a(n) = u(n) * (into < 0 ? f(n) - (into / square) * contact(n) : f(n));
      });
  const auto v = d.nodes.velocity;
  const auto node = d.samples.node;
  const auto weight = d.samples.weight;
  const auto predicted = d.samples.predicted;
  parallel(
      "drench::pressure::sample_velocity", d.samples.count, KOKKOS_LAMBDA(const Index b) {
        Real3 p;
        for (int k = 0; k < 3; ++k) {
          const Index n = node(3 * b + k);
          p += weight(3 * b + k) * (v(n) + dt * a(n));
        }
        predicted(b) = {p, Real(0)};
      });
}

void predict_liquid(Device& d, Real dt, bool touching) {
  const Kernel kernel = d.kernel;
  const Entries<Real3> xb = d.boundary.position, v = d.fluid.velocity;
  const Entries<Real4> place = d.work.place, predicted = d.work.predicted;
  const Entries<Real3> gradient = d.fluid_sample.gradient;
  const Entries<Real> vb = d.boundary.volume, ratio = d.fluid.density_ratio, volume = d.work.volume,
                      push = d.work.contact.push;
  const Neighbors lf = d.fluid_fluid, lb = d.fluid_boundary, ls = d.fluid_sample;
  const bool solids = d.boundary.count > 0, cloth = d.samples.count > 0;
  parallel(
      "drench::pressure::acceleration", d.fluid.count, KOKKOS_LAMBDA(const Index i) {
        const Real4 here = place(i);
        const Real3 xi = here.xyz();
        const Real ki = here.w;
        Real3 a;
        const NeighborRow near = lf.row(i);
        DRENCH_UNROLL
        for (Index k = 0; k < near.count; ++k) {
          const Real4 at = place(near(k));
          a -= (near.slope(k) * (ki + at.w)) * (xi - at.xyz());
        }
        const Real at_sheet = touching ? ki + push(i) : ki;
        if (at_sheet != 0) {
          if (solids) {
            const NeighborRow walls = lb.row(i);
            for (Index k = 0; k < walls.count; ++k) {
              const Index b = walls(k);
              a -= (mirrored * ki * vb(b)) * kernel.gradient(xi - xb(b));
            }
          }
          if (cloth) {
            const Real dense = image_density(ratio(i)) * mirrored * at_sheet;
            const NeighborRow sheets = ls.row(i);
            DRENCH_UNROLL
            for (Index k = 0; k < sheets.count; ++k) a -= dense * gradient(sheets.place(k));
          }
        }
        predicted(i) = {v(i) + dt * a, cloth ? thrust(ratio(i), volume(i), at_sheet) : Real(0)};
      });
}

void compression_rate(Device& d, const Array<Real>& kappa, Real dt, bool touching) {
  const Kernel kernel = d.kernel;
  const Entries<Real3> xb = d.boundary.position, ub = seen_boundary_velocity(d);
  const Entries<Real4> place = d.work.place, v = d.work.predicted, us = d.samples.predicted;
  const Entries<Real3> gradient = d.fluid_sample.gradient;
  const Entries<Real> vb = d.boundary.volume, rate = d.work.rate, compliance = d.work.compliance,
                      ratio = d.fluid.density_ratio, approach = d.work.contact.rate;
  const Neighbors lf = d.fluid_fluid, lb = d.fluid_boundary, ls = d.fluid_sample;
  const bool solids = d.boundary.count > 0, cloth = d.samples.count > 0;
  parallel(
      "drench::pressure::compression_rate", d.fluid.count, KOKKOS_LAMBDA(const Index i) {
        const Real3 xi = place(i).xyz(), vi = v(i).xyz();
        Real sum = 0;
        const NeighborRow near = lf.row(i);
        DRENCH_UNROLL
        for (Index k = 0; k < near.count; ++k) {
          const Index j = near(k);
          sum += near.slope(k) * dot(vi - v(j).xyz(), xi - place(j).xyz());
        }
        if (solids) {
          const NeighborRow walls = lb.row(i);
          for (Index k = 0; k < walls.count; ++k) {
            const Index b = walls(k);
            sum += mirrored * vb(b) * dot(vi - ub(b), kernel.gradient(xi - xb(b)));
          }
        }
        if (cloth) {
          Real sheet = 0;
          const NeighborRow sheets = ls.row(i);
          DRENCH_UNROLL
          for (Index k = 0; k < sheets.count; ++k) sheet += dot(vi - us(sheets(k)).xyz(), gradient(sheets.place(k)));
          sheet *= mirrored * image_density(ratio(i));
          if (touching) approach(i) = sheet;
          sum += sheet;
        }
        rate(i) = sum - dt * compliance(i) * kappa(i);
      });
}

void accept_liquid(Device& d) {
  const auto v = d.fluid.velocity;
  const auto predicted = d.work.predicted;
  parallel(
      "drench::pressure::accept", d.fluid.count, KOKKOS_LAMBDA(const Index i) { v(i) = predicted(i).xyz(); });
}

void accept_free_cloth(Device& d, Real dt) {
  const auto vn = d.nodes.velocity, a = d.nodes.acceleration, f = d.nodes.force, pin = d.nodes.pin_force;
  const auto pinned = d.nodes.pinned;
  parallel(
      "drench::pressure::accept_nodes", d.nodes.count, KOKKOS_LAMBDA(const Index n) {
        if (pinned(n))
          pin(n) -= f(n);
        else
          vn(n) += dt * a(n);
      });
}

}  // namespace drench::kokkos_backend
