// Stage absorption (src/stages/absorption.hpp). Particles that are taken whole stay in the arrays with mass 0, because
// the neighbour lists name them; stage emission removes them, or this one at its end where there is none.

#include "laws/absorption.hpp"

#include "laws/flow.hpp"
#include "primitives/transfer.hpp"

namespace drench::kokkos_backend {
namespace {

/// o_ij of every pair, and Σ_i o_ij in `entering`.
void offer(Device& d, double dt) {
  const auto count = d.fluid_sample.count;
  const auto list = d.fluid_sample.list;
  const auto offers = d.absorption_work.offer;
  const auto x = d.fluid.position, xs = d.samples.position, flow = d.samples.flow_direction;
  const auto mass = d.fluid.mass, entering = d.transfer_work.entering;
  const auto saturation = d.samples.saturation, capacity = d.samples.capacity;
  const auto cloth = d.samples.cloth;
  const auto materials = d.materials;
  const Real h = d.support;
  const double q = d.quantum, rho = d.rest_density;
  const Quanta min_quanta = d.model.min_quanta;
  const bool controlled = d.model.has_saturation_control();
  parallel(
      "drench::absorption::offer", d.fluid.count, KOKKOS_LAMBDA(const Index i) {
        const Quanta m = mass(i);
        const Index n = m > 0 ? count(i) : 0;
        const double volume = double(m) * q / rho;
        const auto wish = [&](const Index j) -> double {
          const Index c = cloth(j);
          if (!materials(c).porous) return 0;
          const Real3 separation = xs(j) - x(i);
          const Real cap = laws::saturation_cap(materials(c).max_saturation, laws::flow_cosine(separation, flow(j), h));
          const Real deficit = controlled ? cap - saturation(j) : Real(1);
          if (!(deficit > 0)) return 0;
          return laws::absorption_wish(dt, materials(c).absorption, capacity(j) / q, deficit, volume,
                                       laws::viscosity_laplacian(norm(separation), h));
        };
        double all = 0;
        for (Index k = 0; k < n; ++k) all += wish(list(i, k));
        const double total = all > 0 ? laws::absorption_total(double(m), all) : 0;
        Quanta rest = m;
        Index largest = 0;
        for (Index k = 0; k < n; ++k) {
          const Quanta wanted = all > 0 ? static_cast<Quanta>(Kokkos::floor(total * (wish(list(i, k)) / all))) : 0;
          const Quanta o = wanted < rest ? wanted : rest;
          offers(i, k) = o;
          rest -= o;
          if (o > offers(i, largest)) largest = k;
        }
        if (rest < m && rest > 0 && rest < min_quanta) offers(i, largest) += rest;
        for (Index k = 0; k < n; ++k)
          if (offers(i, k) > 0) Kokkos::atomic_add(&entering(list(i, k)), offers(i, k));
      });
}

/// t_ij of every pair: mass leaves the liquid; mass and momentum are on their way in `entering` and `momentum`.
void transfer(Device& d) {
  const auto count = d.fluid_sample.count;
  const auto list = d.fluid_sample.list;
  const auto offers = d.absorption_work.offer;
  const auto mass = d.fluid.mass, entering = d.transfer_work.entering;
  const auto velocity = d.fluid.velocity;
  const auto share = d.transfer_work.inflow_share;
  const auto momentum = d.transfer_work.momentum;
  const Quanta min_quanta = d.model.min_quanta;
  parallel(
      "drench::absorption::transfer", d.fluid.count, KOKKOS_LAMBDA(const Index i) {
        const Quanta m = mass(i);
        const Index n = m > 0 ? count(i) : 0;
        Quanta rest = m;
        bool was_limited = false;
        for (Index k = 0; k < n; ++k) {
          const Quanta o = offers(i, k);
          if (o == 0) continue;
          const double phi = share(list(i, k));
          if (phi < 1) was_limited = true;
          offers(i, k) = limited(o, phi);
          rest -= offers(i, k);
        }
        Quanta back = was_limited && rest > 0 && rest < min_quanta ? min_quanta - rest : 0;
        for (Index k = 0; k < n; ++k) {
          Quanta t = offers(i, k);
          const Quanta cut = t < back ? t : back;
          t -= cut;
          rest += cut;
          back -= cut;
          if (t == 0) continue;
          Kokkos::atomic_add(&entering(list(i, k)), t);
          add_momentum(momentum, list(i, k), t, velocity(i));
        }
        mass(i) = rest;
      });
}

}  // namespace

void absorption(Device& d, const StepInfo& info, StepReport&) {
  if (d.fluid.count == 0 || d.samples.count == 0) return;
  make_room(d.absorption_work.offer, "drench::absorption::offer", d.fluid_sample.list);
  refresh_samples(d);
  refresh_saturation(d);
  clear_transfers(d, true);
  offer(d, info.dt);
  limit_inflow(d, d.model.has_saturation_control());
  clear_transfers(d, true);
  transfer(d);
  deliver(d);
  if (!d.model.has_emission()) d.compact_fluid({});
}

}  // namespace drench::kokkos_backend
