// Stage micropolar (src/stages/micropolar.hpp).

#include "core/liquid_pairs.hpp"
#include "core/reduce.hpp"
#include "core/runge_kutta_legendre.hpp"
#include "fluid/micropolar_law.hpp"
#include "fluid/stages.hpp"

namespace drench::kokkos_backend {
namespace {

/// The largest g_i, 1/m, and k_i, 1.
struct SpinBounds {
  double steepness = 0, moment = 0;
  KOKKOS_INLINE_FUNCTION SpinBounds& operator+=(const SpinBounds& o) {
    if (o.steepness > steepness) steepness = o.steepness;
    if (o.moment > moment) moment = o.moment;
    return *this;
  }
};

/// Work arrays, on first use.
void allocate(Fluid& fluid, MicropolarWork& work) {
  make_room(work.slip, "drench::micropolar::slip", fluid.particles.position.extent(0));
  make_room(work.rate, "drench::micropolar::rate", fluid.particles.position.extent(0));
}

}  // namespace

MemoryEstimate micropolar_bytes(const Sizing& s) {
  MemoryEstimate sum;
  if (s.size.micropolar) sum.particles = particle_room(s) * 8 * s.real;
  return sum;
}

namespace {

/// s′_i and dω_i/dt of the flow and the spins as they are, with g_i and k_i.
void measure_slip(Fluid& fluid, const NeighborLists& lists, MicropolarWork& work, const SpinLaw& law,
                  const Kernel& kernel) {
  fluid.exchange.halo(fluid.particles.velocity);
  fluid.exchange.halo(fluid.particles.spin);
  const Entries<const Real3> v = std::as_const(fluid).particles.velocity, spin = std::as_const(fluid).particles.spin;
  const Entries<const Real4> position = std::as_const(fluid).position_volume;
  const Entries<Real4> slip = work.slip, rate = work.rate;
  const LiquidPairs pairs(lists.fluid_fluid, kernel, fluid.volume);
  const bool spreads = law.spread > 0;
  parallel(
      "drench::micropolar::slip", fluid.particles.count, KOKKOS_LAMBDA(const Index i) {
        const Real3 vi = v(i), wi = spin(i);
        SpinSum sum;
        pairs.for_each(i, position, [&](Index j, const Real4&, const Real3& x, Real factor) {
          const Real b = -factor;
          sum.add(b, x, vi - v(j));
          if (spreads) sum.spread += law.spreading(b, norm(x)) * (spin(j) - wi);
        });
        const Real3 s = sum.curl - sum.rigid_curl(wi);
        slip(i) = {s - law.free * sum.curl, sum.steepness};
        rate(i) = {(law.half_transfer * law.per_inertia) * sum.rigid_curl(s) + law.spread * sum.spread, sum.trace()};
      });
  fluid.exchange.halo(work.slip);
}

/// C, 1/s. The host waits.
double rate_bound(const Fluid& fluid, const MicropolarWork& work, const SpinLaw& law) {
  const Entries<const Real4> slip = work.slip, rate = work.rate;
  const auto term = KOKKOS_LAMBDA(const Index i) { return SpinBounds{double(slip(i).w), double(rate(i).w)}; };
  SpinBounds most = reduced<SpinBounds>("drench::micropolar::bound", fluid.particles.count,
                                        Added<SpinBounds, std::decay_t<decltype(term)>>{term});
  OverRanks(fluid.exchange.ranks()).maximum(most.steepness).maximum(most.moment).reduce();
  return double(law.half_transfer) *
             (4 * most.steepness * most.steepness + most.moment * most.moment * double(law.per_inertia)) +
         2 * double(law.spread) / double(law.least) * most.steepness;
}

/// A stage: v_i and ω_i change by their D_k, which the next one needs where there are `several`.
void turn(Fluid& fluid, const NeighborLists& lists, MicropolarWork& work, const SpinLaw& law,
          const LegendreStage& stage, const Kernel& kernel, bool several) {
  const Entries<Real3> v = fluid.particles.velocity, spin = fluid.particles.spin, flow_change = work.velocity_change,
                       spin_change = work.spin_change;
  const Entries<const Real4> position = fluid.position_volume, slip = work.slip, rate = work.rate;
  const LiquidPairs pairs(lists.fluid_fluid, kernel, fluid.volume);
  parallel(
      "drench::micropolar::turn", fluid.particles.count, KOKKOS_LAMBDA(const Index i) {
        const Real3 si = slip(i).xyz();
        Real3 sum;
        pairs.for_each_or_self(i, position, [&](Index j, const Real4&, const Real3& x, Real factor) {
          sum += factor * cross(si + slip(j).xyz(), x);
        });
        Real3 flow = (stage.weight * law.half_transfer) * sum, spin_up = stage.weight * rate(i).xyz();
        if (several) {
          if (stage.keep > 0) {
            flow += stage.keep * flow_change(i);
            spin_up += stage.keep * spin_change(i);
          }
          flow_change(i) = flow;
          spin_change(i) = spin_up;
        }
        v(i) += flow;
        spin(i) += spin_up;
      });
}

}  // namespace

void micropolar(const Constants& constants, Fluid& fluid, const NeighborLists& lists, MicropolarWork& work,
                const StepInfo& info, StepReport& report) {
  if (fluid.particles.total == 0) return;
  allocate(fluid, work);
  const SpinLaw law(constants.model.scene.fluid.micropolar, constants.model.spacing, constants.model.support);
  measure_slip(fluid, lists, work, law, constants.kernel);
  const double bound = rate_bound(fluid, work, law);
  int stages = 1;
  while (stages * (stages + 1.0) < info.dt * bound) ++stages;
  report.micropolar_stages = stages;
  if (stages > 1) {
    make_room(work.velocity_change, "drench::micropolar::velocity_change", fluid.particles.position.extent(0));
    make_room(work.spin_change, "drench::micropolar::spin_change", fluid.particles.position.extent(0));
  }
  for (int k = 1; k <= stages; ++k) {
    if (k > 1) measure_slip(fluid, lists, work, law, constants.kernel);
    turn(fluid, lists, work, law, legendre(k, stages, info.dt), constants.kernel, stages > 1);
  }
}

}  // namespace drench::kokkos_backend
