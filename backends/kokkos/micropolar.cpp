// Stage micropolar (src/stages/micropolar.hpp).

#include "laws/micropolar.hpp"

#include "device.hpp"
#include "laws/runge_kutta_legendre.hpp"
#include "primitives/reduce.hpp"

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
void allocate(Device& d) {
  MicropolarWork& w = d.micropolar_work;
  make_room(w.slip, "drench::micropolar::slip", d.fluid.position.extent(0));
  make_room(w.rate, "drench::micropolar::rate", d.fluid.position.extent(0));
}

/// s′_i and dω_i/dt of the flow and the spins as they are, with g_i and k_i.
void measure_slip(const Device& d, const SpinLaw& law) {
  const Entries<Real3> v = d.fluid.velocity, spin = d.fluid.spin;
  const Entries<Real4> place = d.work.place, slip = d.micropolar_work.slip, rate = d.micropolar_work.rate;
  const Neighbors list = d.fluid_fluid;
  const bool spreads = law.spread > 0;
  parallel(
      "drench::micropolar::slip", d.fluid.count, KOKKOS_LAMBDA(const Index i) {
        const Real3 xi = place(i).xyz(), vi = v(i), wi = spin(i);
        SpinSum sum;
        const NeighborRow near = list.row(i);
        DRENCH_UNROLL
        for (Index k = 0; k < near.count; ++k) {
          const Index j = near(k);
          const Real3 x = xi - place(j).xyz();
          const Real b = -near.slope(k);
          sum.add(b, x, vi - v(j));
          if (spreads) sum.spread += (b * dot(x, x)) * (spin(j) - wi);
        }
        const Real3 s = sum.curl - sum.turned(wi);
        slip(i) = {s - law.free * sum.curl, sum.steepness};
        rate(i) = {(law.half_transfer * law.per_inertia) * sum.turned(s) + law.spread * sum.spread, sum.trace()};
      });
}

/// C, 1/s. The host waits.
double rate_bound(const Device& d, const SpinLaw& law) {
  const Entries<Real4> slip = d.micropolar_work.slip, rate = d.micropolar_work.rate;
  const auto term = KOKKOS_LAMBDA(const Index i) { return SpinBounds{double(slip(i).w), double(rate(i).w)}; };
  const SpinBounds most = reduced<SpinBounds>("drench::micropolar::bound", d.fluid.count,
                                              Added<SpinBounds, std::decay_t<decltype(term)>>{term});
  return double(law.half_transfer) *
             (4 * most.steepness * most.steepness + most.moment * most.moment * double(law.per_inertia)) +
         2 * double(law.spread) * most.moment;
}

/// A stage: v_i and ω_i change by their D_k, which the next one needs where there are `several`.
void turn(const Device& d, const SpinLaw& law, const LegendreStage& stage, bool several) {
  const Entries<Real3> v = d.fluid.velocity, spin = d.fluid.spin, flow_change = d.micropolar_work.velocity_change,
                       spin_change = d.micropolar_work.spin_change;
  const Entries<Real4> place = d.work.place, slip = d.micropolar_work.slip, rate = d.micropolar_work.rate;
  const Neighbors list = d.fluid_fluid;
  parallel(
      "drench::micropolar::turn", d.fluid.count, KOKKOS_LAMBDA(const Index i) {
        const Real3 xi = place(i).xyz(), si = slip(i).xyz();
        Real3 sum;
        const NeighborRow near = list.row(i);
        DRENCH_UNROLL
        for (Index k = 0; k < near.count; ++k) {
          const Index j = near(k);
          sum += near.slope(k) * cross(si + slip(j).xyz(), xi - place(j).xyz());
        }
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

void micropolar(Device& d, const StepInfo& info, StepReport&) {
  if (d.fluid.count == 0) return;
  allocate(d);
  const SpinLaw law(d.model.scene.fluid.micropolar, d.model.scene.fluid.kernel, d.model.spacing, d.model.support);
  measure_slip(d, law);
  const double bound = rate_bound(d, law);
  int stages = 1;
  while (stages * (stages + 1.0) < info.dt * bound) ++stages;
  if (stages > 1) {
    make_room(d.micropolar_work.velocity_change, "drench::micropolar::velocity_change", d.fluid.position.extent(0));
    make_room(d.micropolar_work.spin_change, "drench::micropolar::spin_change", d.fluid.position.extent(0));
  }
  for (int k = 1; k <= stages; ++k) {
    if (k > 1) measure_slip(d, law);
    turn(d, law, legendre(k, stages, info.dt), stages > 1);
  }
}

}  // namespace drench::kokkos_backend
