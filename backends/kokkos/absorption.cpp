// Stage absorption (src/stages/absorption.hpp). Particles that are taken whole stay in the arrays with mass 0, because
// the neighbour lists name them; stage emission removes them, or this one at its end where there is none.

#include "laws/absorption.hpp"

#include "laws/flow.hpp"
#include "primitives/transfer.hpp"

namespace drench::kokkos_backend {
namespace {

/// s_p of every sample (a node with C_n = 0 counts 0); nothing is on its way to any.
void prepare(Device& d) {
  const Entries<Index> node = d.samples.node;
  const Entries<Real> weight = d.samples.weight, saturation = d.samples.saturation;
  const Entries<Quanta> liquid = d.nodes.liquid;
  const Entries<double> capacity = d.nodes.capacity;
  const double q = d.quantum;
  const Transfers transfers(d);
  parallel(
      "drench::absorption::saturation", d.samples.count, KOKKOS_LAMBDA(const Index p) {
        double sum = 0;
        for (int k = 0; k < 3; ++k) {
          const Index n = node(3 * p + k);
          if (capacity(n) > 0) sum += double(weight(3 * p + k)) * (double(liquid(n)) * q / capacity(n));
        }
        saturation(p) = Real(sum);
        transfers.clear(p);
      });
}

/// o_ij of every pair, and Σ_i o_ij in `offered`.
void offer(Device& d, double dt) {
  const Neighbors list(d.fluid_sample);
  const auto offers = d.absorption_work.offer;
  const Entries<Real3> x = d.fluid.position, xs = d.samples.position, flow = d.samples.flow_direction;
  const Entries<Quanta> mass = d.fluid.mass, offered = d.transfer_work.offered;
  const Entries<Real> saturation = d.samples.saturation, capacity = d.samples.capacity;
  const Entries<Index> cloth = d.samples.cloth;
  const Entries<Material> materials = d.materials;
  const Real h = d.support;
  const double q = d.quantum, rho = d.rest_density;
  const Quanta min_quanta = d.model.min_quanta;
  const bool controlled = d.model.has_saturation_control();
  parallel(
      "drench::absorption::offer", d.fluid.count, KOKKOS_LAMBDA(const Index i) {
        const Quanta m = mass(i);
        const Index n = m > 0 ? list.count(i) : 0;
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
        for (Index k = 0; k < n; ++k) {
          const double w = wish(list(i, k));
          offers(i, k) = Kokkos::bit_cast<Quanta>(w);  // kept there until it is an offer
          all += w;
        }
        const double total = all > 0 ? laws::absorption_total(double(m), all) : 0;
        Quanta rest = m;
        Index largest = 0;
        for (Index k = 0; k < n; ++k) {
          const double w = Kokkos::bit_cast<double>(offers(i, k));
          const Quanta wanted = all > 0 ? static_cast<Quanta>(Kokkos::floor(total * (w / all))) : 0;
          const Quanta o = wanted < rest ? wanted : rest;
          offers(i, k) = o;
          rest -= o;
          if (o > offers(i, largest)) largest = k;
        }
        if (rest < m && rest > 0 && rest < min_quanta) offers(i, largest) += rest;
        for (Index k = 0; k < n; ++k)
          if (offers(i, k) > 0) Kokkos::atomic_add(&offered(list(i, k)), offers(i, k));
      });
}

/// t_ij of every pair: mass leaves the liquid; mass and momentum are on their way in `entering` and `momentum`.
void transfer(Device& d) {
  const Neighbors list(d.fluid_sample);
  const auto offers = d.absorption_work.offer;
  const Entries<Quanta> mass = d.fluid.mass;
  const Entries<Real3> velocity = d.fluid.velocity;
  const Transfers transfers(d);
  const Quanta min_quanta = d.model.min_quanta;
  parallel(
      "drench::absorption::transfer", d.fluid.count, KOKKOS_LAMBDA(const Index i) {
        const Quanta m = mass(i);
        const Index n = m > 0 ? list.count(i) : 0;
        Quanta rest = m;
        bool was_limited = false;
        for (Index k = 0; k < n; ++k) {
          const Quanta o = offers(i, k);
          if (o == 0) continue;
          const double phi = transfers.share(list(i, k));
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
          transfers.give(list(i, k), t, velocity(i));
        }
        mass(i) = rest;
      });
}

/// Removes what was taken whole.
void remove_taken(Device& d) {
  auto& taken = d.absorption_work.taken;
  if (taken.data() == nullptr)
    taken = std::decay_t<decltype(taken)>(Kokkos::ViewAllocateWithoutInitializing("drench::absorption::taken"));
  const Entries<Quanta> mass = d.fluid.mass;
  Kokkos::parallel_reduce(
      "drench::absorption::taken", Range(0, d.fluid.count),
      KOKKOS_LAMBDA(const Index i, Index& sum) { sum += mass(i) > 0 ? 0 : 1; }, taken);
  ExecSpace().fence("drench::absorption::taken");
  d.compact_fluid({}, d.fluid.count - taken());
}

}  // namespace

void absorption(Device& d, const StepInfo& info, StepReport&) {
  if (d.fluid.count == 0 || d.samples.count == 0) return;
  make_room(d.absorption_work.offer, "drench::absorption::offer", d.fluid_sample.list);
  prepare_transfers(d);
  place_samples(d);
  prepare(d);
  offer(d, info.dt);
  limit_inflow(d, d.model.has_saturation_control());
  transfer(d);
  parallel("drench::absorption::deliver", d.nodes.count, Delivery(d));
  if (!d.model.has_emission()) remove_taken(d);
}

}  // namespace drench::kokkos_backend
