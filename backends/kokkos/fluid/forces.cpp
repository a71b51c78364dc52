// Stage forces (src/stages/forces.hpp).

#include <algorithm>
#include <cmath>

#include "base/stop_request.hpp"
#include "core/liquid_pairs.hpp"
#include "core/quads.hpp"
#include "core/reduce.hpp"
#include "core/runge_kutta_legendre.hpp"
#include "coupling/body_response.hpp"
#include "fluid/stages.hpp"
#include "particles/viscosity.hpp"

namespace drench::kokkos_backend {
namespace {

#ifdef DRENCH_LANES
/// ViscousSum::add for all liquid neighbours, four at once; `moving`: velocity and 1/√δ.
void add_liquid_friction(const Entries<const Real4>& position, const Entries<const Real4>& moving,
                         const NeighborRow& near, Index i, ViscousSum& sum) {
  const Quad xi = quad(position(i)), vi = quad(moving(i));
  Quad pull{}, other_pull{}, bound{};
  for (Index k = 0; k < near.count; k += 4) {
    Quad r[4], products[4], squares[4], factor{};
    for (Index p = 0; p < 4; ++p) {
      const bool there = k + p < near.count;
      const Real4& other = moving(there ? near(k + p) : i);
      r[p] = xi - quad(position(there ? near(k + p) : i));
      products[p] = (vi - quad(other)) * r[p];
      squares[p] = r[p] * r[p];
      factor[p] = there ? near.grad_factor(k + p) * other.w : Real(0);
    }
    const Quad along = factor * FourVectors(products).sum();
    pull += along[0] * r[0];
    other_pull += along[1] * r[1];
    pull += along[2] * r[2];
    other_pull += along[3] * r[3];
    bound -= factor * FourVectors(squares).sum();
  }
  pull += other_pull;
  sum.pull += {pull[0], pull[1], pull[2]};
  sum.bound += (bound[0] + bound[2]) + (bound[1] + bound[3]);
}
#endif

/// Gravity and the field alone.
void inviscid(const Constants& constants, Fluid& fluid, Real dt) {
  const Real3 g = constants.gravity, center = constants.field_center, square = constants.field_square;
  const bool field = constants.model.scene.field.present;
  const Entries<const Real3> x = fluid.particles.position;
  const Entries<Real3> v = fluid.particles.velocity;
  parallel(
      "drench::forces::velocity", fluid.particles.count,
      KOKKOS_LAMBDA(const Index i) { v(i) += dt * (field ? g + central_field(x(i), center, square) : g); });
}

/// v_i and 1/√δ_i in work.velocity_and_weight: with these shares the pairs' mean costs nothing.
void pair_shares(const Fluid& fluid, ForcesWork& work) {
  const std::size_t n = fluid.particles.capacity();
  make_room(work.velocity_and_weight, "drench::forces::velocity_and_weight", n);
  make_room(work.change, "drench::forces::change", n);
  make_room(work.bound, "drench::forces::bound", n);
  const Entries<const Real> ratio = fluid.particles.density_ratio;
  const Entries<const Real3> v = fluid.particles.velocity;
  const Entries<Real4> moving = work.velocity_and_weight;
  parallel(
      "drench::forces::pair_share", fluid.particles.count, KOKKOS_LAMBDA(const Index i) {
        moving(i) = {v(i), 1 / Kokkos::sqrt(bounded_ratio(ratio(i)))};
      });
  fluid.exchange.halo(work.velocity_and_weight);
}

/// The liquid's change in a stage, in work.change, and C_i, 1/s, in work.bound.
template <class Friction>
void find_liquid_change(const Constants& constants, const Fluid& fluid, const NeighborLists& lists,
                        const Bodies& bodies, const Cloth& cloth, ForcesWork& work, const LegendreStage& stage,
                        const Friction& friction) {
  const Kernel kernel = constants.kernel;
  const Real strength = viscous_strength(constants);
  const Real3 g = constants.gravity, center = constants.field_center, square = constants.field_square;
  const bool field = constants.model.scene.field.present;
  const bool solids = bodies.boundary.count > 0, sheets = cloth.samples.count > 0;
  const Entries<const Real3> xb = bodies.boundary.position, ub = bodies.boundary.velocity, us = cloth.samples.velocity;
  const Entries<const Real4> position = fluid.position_volume, moving = work.velocity_and_weight,
                             xs = cloth.samples.position_volume;
  const Entries<Real4> change = work.change;
  const Entries<Real> bound = work.bound;
  const LiquidPairs lf(lists.fluid_fluid, kernel, fluid.volume);
  const Neighbors lb(lists.fluid_boundary), ls(lists.fluid_sample);
  // The bounds by themselves: a reduction's blocks have fewer threads at once than the neighbours' loads need.
  parallel(
      "drench::forces::liquid", fluid.particles.count, KOKKOS_LAMBDA(const Index i) {
        const Real3 xi = position(i).xyz(), vi = moving(i).xyz();
        const Real share = moving(i).w;
        ViscousSum sum;
#ifdef DRENCH_LANES
        add_liquid_friction(position, moving, lf.row(i), i, sum);
#else
        lf.for_each_or_self(i, position, [&](Index j, const Real4&, const Real3& r, Real factor) {
          const Real4 other = moving(j);
          sum.add(other.w, vi - other.xyz(), r, factor * r);
        });
#endif
        if (solids) {
          lb.for_each(i, [&](Index b, Real factor) {
            const Real3 r = xi - xb(b);
            friction.at_body(sum, b, solid_friction * share, vi - ub(b), r, factor * r);
          });
        }
        if (sheets) {
          ls.for_each(i, [&](Index b) {
            const Real4 at = xs(b);
            const Real3 r = xi - at.xyz();
            friction.at_sheet(sum, b, sheet_friction * share * at.w, vi - us(b), r, kernel.gradient(r));
          });
        }
        Real3 rate = g + (strength * share) * sum.pull;
        if (field) rate += central_field(xi, center, square);
        Real3 next = stage.weight * rate;
        if (stage.keep != 0) next += stage.keep * change(i).xyz();
        change(i) = {next, Real(0)};
        bound(i) = strength * share * sum.bound;
      });
}

void liquid_change(const Constants& constants, const Fluid& fluid, const NeighborLists& lists, const Bodies& bodies,
                   const Cloth& cloth, ForcesWork& work, const LegendreStage& stage) {
  with_slip(constants, work.slip, bodies, cloth, [&](const auto& friction) {
    find_liquid_change(constants, fluid, lists, bodies, cloth, work, stage, friction);
  });
}

/// Adds the largest C_i, 1/s.
void find_liquid_bound(const Fluid& fluid, const ForcesWork& work, MaximaUnderWay& maxima) {
  const Entries<const Real> bound = work.bound;
  maxima.add(
      "drench::forces::bound", fluid.particles.count, KOKKOS_LAMBDA(const Index i) { return double(bound(i)); });
}

void add_change(Fluid& fluid, ForcesWork& work) {
  const Entries<Real3> v = fluid.particles.velocity;
  const Entries<Real4> moving = work.velocity_and_weight;
  const Entries<const Real4> change = work.change;
  parallel(
      "drench::forces::velocity", fluid.particles.count, KOKKOS_LAMBDA(const Index i) {
        v(i) += change(i).xyz();
        moving(i) = {v(i), moving(i).w};
      });
  fluid.exchange.halo(work.velocity_and_weight);
}

/// The reaction on samples, in samples.force.
template <class Friction>
void find_sample_forces(const Constants& constants, const Fluid& fluid, const NeighborLists& lists, Cloth& cloth,
                        ForcesWork& work, const Friction& friction) {
  allocate_zeros(work.sample_bound, "drench::forces::sample_bound", static_cast<std::size_t>(cloth.samples.count));
  const Kernel kernel = constants.kernel;
  const Real strength = sheet_friction * viscous_strength(constants) * constants.rest_density;
  const Entries<const Real3> xs = cloth.samples.position, xf = fluid.particles.position, us = cloth.samples.velocity,
                             v = fluid.particles.velocity;
  const Entries<Real3> force = cloth.samples.force;
  const Entries<const Real> vs = cloth.samples.volume, volume = fluid.volume, ratio = fluid.particles.density_ratio;
  const Entries<Real> bound = work.sample_bound;
  const Neighbors list(lists.sample_fluid);
  parallel(
      "drench::forces::sample_force", cloth.samples.count, KOKKOS_LAMBDA(const Index b) {
        ViscousSum sum;
        const Real3 here = xs(b), moves = us(b);
        list.for_each(b, [&](Index i) {
          const Real3 r = here - xf(i);
          friction.at_sheet(sum, b, volume(i) / bounded_ratio(ratio(i)), moves - v(i), r, kernel.gradient(r));
        });
        force(b) = (strength * vs(b)) * sum.pull;
        bound(b) = strength * vs(b) * sum.bound;
      });
}

/// The same on the nodes, in nodes.force.
void cloth_forces(const Constants& constants, Fluid& fluid, const NeighborLists& lists, const Bodies& bodies,
                  Cloth& cloth, ForcesWork& work) {
  fluid.exchange.halo(fluid.particles.velocity);
  fluid.exchange.halo(fluid.particles.density_ratio);
  with_slip(constants, work.slip, bodies, cloth,
            [&](const auto& friction) { find_sample_forces(constants, fluid, lists, cloth, work, friction); });
  fluid.exchange.share(cloth.samples.force, cloth.samples.count);
  fluid.exchange.share(work.sample_bound, cloth.samples.count);
  node_forces_from_samples(cloth);
}

}  // namespace

/// Without impulse_change, which comes with several stages (docs/dev/memory_estimate.md).
MemoryEstimate forces_bytes(const Sizing& s) {
  MemoryEstimate sum = slip_bytes(s);
  if (!s.size.liquid || !(s.size.scene.fluid.viscosity > 0)) return sum;
  sum.particles += particle_room(s) * 9 * s.real;  // velocity_and_weight, change, bound
  sum.cloth += s.size.samples * s.real;            // sample_bound
  return sum;
}

namespace {

/// Adds the largest u_n Σ_b w_bn K_b, 1/s.
void find_node_bound(Cloth& cloth, const ForcesWork& work, MaximaUnderWay& maxima) {
  node_bounds_from_samples("drench::forces::node_row", cloth, std::as_const(work).sample_bound);
  const Entries<const Real> node_bound = cloth.nodes.row_bound;
  maxima.add(
      "drench::forces::node_bound", cloth.nodes.count, KOKKOS_LAMBDA(const Index n) { return double(node_bound(n)); });
}

/// A stage of the nodes: their impulse J grows by its own D_k.
void node_stage(Cloth& cloth, ForcesWork& work, const LegendreStage& stage, Real dt) {
  const Entries<Real3> change = work.impulse_change, v = cloth.nodes.velocity, pin = cloth.nodes.pin_force;
  const Entries<const Real3> f = cloth.nodes.force;
  const Entries<const Real> u = cloth.nodes.inverse_mass;
  const Entries<const std::uint8_t> fixed = cloth.nodes.fixed;
  parallel(
      "drench::forces::node_stage", cloth.nodes.count, KOKKOS_LAMBDA(const Index n) {
        const Real3 next = stage.keep * change(n) + stage.weight * f(n);
        change(n) = next;
        if (fixed(n))
          pin(n) -= (1 / dt) * next;
        else
          v(n) += u(n) * next;
      });
}

/// All stages, the forces of the first being there and its change made with the whole Δt.
void many_stages(const Constants& constants, Fluid& fluid, const NeighborLists& lists, Bodies& bodies, Cloth& cloth,
                 ForcesWork& work, int stages, double dt) {
  const bool sheets = cloth.samples.count > 0;
  const Entries<Real4> change = work.change;
  const Real share = Real(2 / (double(stages) * (stages + 1.0)));
  parallel(
      "drench::forces::first_stage", fluid.particles.count, KOKKOS_LAMBDA(const Index i) {
        change(i) = {share * change(i).xyz(), Real(0)};
      });
  if (sheets)
    allocate_zeros(work.impulse_change, "drench::forces::impulse_change", static_cast<std::size_t>(cloth.nodes.count));
  for (int k = 1; k <= stages; ++k) {
    stop_if_requested();
    const LegendreStage stage = legendre(k, stages, dt);
    if (k > 1) {
      viscous_body_forces(constants, fluid, lists, bodies, cloth, work.slip);
      if (sheets) {
        refresh_samples(cloth);
        cloth_forces(constants, fluid, lists, bodies, cloth, work);
      }
      liquid_change(constants, fluid, lists, bodies, cloth, work, stage);
    }
    add_change(fluid, work);
    if (sheets) node_stage(cloth, work, stage, Real(dt));
    body_stage(bodies, double(stage.keep), double(stage.weight), &constants);
  }
}

}  // namespace

void forces(const Constants& constants, Fluid& fluid, const NeighborLists& lists, Bodies& bodies, Cloth& cloth,
            ForcesWork& work, const StepInfo& info, StepReport& report) {
  if (viscous_strength(constants) == 0) {
    viscous_body_forces(constants, fluid, lists, bodies, cloth, work.slip);  // none
    body_stage(bodies, 0, info.dt, &constants);
    inviscid(constants, fluid, Real(info.dt));
    return;
  }
  const bool sheets = cloth.samples.count > 0;
  refresh_slip(constants, bodies, info, work.slip);
  pair_shares(fluid, work);
  if (sheets) {
    refresh_samples(cloth);  // the divergence solve has changed the nodes' velocities
    refresh_inverse_mass(constants, cloth);
    cloth_forces(constants, fluid, lists, bodies, cloth, work);
  }
  viscous_body_forces(constants, fluid, lists, bodies, cloth, work.slip);
  liquid_change(constants, fluid, lists, bodies, cloth, work, legendre(1, 1, info.dt));
  MaximaUnderWay maxima;
  find_liquid_bound(fluid, work, maxima);
  if (sheets) find_node_bound(cloth, work, maxima);
  find_viscous_body_bound(bodies, maxima);
  const double bound = maxima.wait("drench::forces::bound", constants.ranks);
  int stages = 1;
  while (stages * (stages + 1.0) < 2 * info.dt * bound) ++stages;
  report.viscosity_stages = stages;
  if (stages > 1) {
    many_stages(constants, fluid, lists, bodies, cloth, work, stages, info.dt);
    return;
  }
  add_change(fluid, work);
  if (sheets) apply_node_forces(cloth, Real(info.dt));
  body_stage(bodies, 0, info.dt, &constants);
}

}  // namespace drench::kokkos_backend
