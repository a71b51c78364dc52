// Stage absorption (src/stages/absorption.hpp). Particles that are taken whole stay in the arrays with mass 0, because
// the neighbour lists name them; stage emission removes them, or this one at its end where there is none.

#include "laws/absorption.hpp"

#include "laws/flow.hpp"
#include "primitives/transfer.hpp"

namespace drench::kokkos_backend {
namespace {

/// s_p of every sample (a node with C_n = 0 counts 0), and what `offer` asks about it; nothing is on its way to any.
void prepare(Device& d) {
  const auto samples = static_cast<std::size_t>(d.samples.count);
  auto& w = d.absorption_work;
  make_room(w.place, "drench::absorption::place", samples);
  make_room(w.course, "drench::absorption::course", samples);
  const Entries<Real4> place = w.place, course = w.course;
  const Entries<Real3> x = d.samples.position, flow = d.samples.flow_direction;
  const Entries<Index> node = d.samples.node;
  const Entries<Real> weight = d.samples.weight, saturation = d.samples.saturation, capacity = d.samples.capacity;
  const Entries<Quanta> liquid = d.nodes.liquid;
  const Entries<double> node_capacity = d.nodes.capacity;
  const double q = d.quantum;
  const Transfers transfers(d);
  parallel(
      "drench::absorption::saturation", d.samples.count, KOKKOS_LAMBDA(const Index p) {
        double sum = 0;
        for (int k = 0; k < 3; ++k) {
          const Index n = node(3 * p + k);
          if (node_capacity(n) > 0) sum += double(weight(3 * p + k)) * (double(liquid(n)) * q / node_capacity(n));
        }
        saturation(p) = Real(sum);
        place(p) = {x(p), Real(sum)};
        course(p) = {flow(p), capacity(p)};
        transfers.clear(p);
      });
}

/// Wishes of one particle.
struct Wishes {
  Entries<Real4> place, course;
  Entries<Index> cloth;
  Entries<Material> materials;
  double dt, q;
  Real h;
  bool controlled, single;  // one cloth

  Wishes(const Device& d, double step)
      : place(d.absorption_work.place),
        course(d.absorption_work.course),
        cloth(d.samples.cloth),
        materials(d.materials),
        dt(step),
        q(d.quantum),
        h(d.support),
        controlled(d.model.has_saturation_control()),
        single(d.materials.extent(0) == 1) {}

  /// w_ij, quanta, of liquid at x with the volume V_i, m³.
  KOKKOS_INLINE_FUNCTION double operator()(const Real3& x, double volume, Index j) const {
    const Index c = single ? 0 : cloth(j);
    if (!materials(c).porous) return 0;
    const Real4 at = place(j), course_at = course(j);
    const Real3 separation = at.xyz() - x;
    const Real cap =
        laws::saturation_cap(materials(c).max_saturation, laws::flow_cosine(separation, course_at.xyz(), h));
    const Real deficit = controlled ? cap - at.w : Real(1);
    if (!(deficit > 0)) return 0;
    return laws::absorption_wish(dt, materials(c).absorption, course_at.w / q, deficit, volume,
                                 laws::viscosity_laplacian(norm(separation), h));
  }
};

/// o_ij of every pair, and Σ_i o_ij in `offered`.
void offer(Device& d, double dt) {
  const Neighbors list(d.fluid_sample);
  const Entries<Quanta> offers = d.absorption_work.offer;
  const Entries<Real3> x = d.fluid.position;
  const Entries<Quanta> mass = d.fluid.mass, offered = d.transfer_work.offered;
  const double q = d.quantum, rho = d.rest_density;
  const Quanta min_quanta = d.model.min_quanta;
  const Wishes wish(d, dt);
  parallel(
      "drench::absorption::offer", d.fluid.count, KOKKOS_LAMBDA(const Index i) {
        const NeighborRow near = list.row(i);
        const Quanta m = near.count > 0 ? mass(i) : 0;
        if (m <= 0) return;
        const Real3 at = x(i);
        const double volume = double(m) * q / rho;
        double all = 0;
        for (Index k = 0; k < near.count; ++k) {
          const double w = wish(at, volume, near(k));
          offers(near.place(k)) = Kokkos::bit_cast<Quanta>(w);  // kept there until it is an offer
          all += w;
        }
        const double total = all > 0 ? laws::absorption_total(double(m), all) : 0;
        Quanta rest = m, most = 0;
        Index largest = 0;
        for (Index k = 0; k < near.count; ++k) {
          const double w = Kokkos::bit_cast<double>(offers(near.place(k)));
          Quanta o = 0;
          if (w > 0) {
            const auto wanted = static_cast<Quanta>(Kokkos::floor(total * (w / all)));
            o = wanted < rest ? wanted : rest;
          }
          offers(near.place(k)) = o;
          if (o == 0) continue;
          rest -= o;
          Kokkos::atomic_add(&offered(near(k)), o);
          if (o <= most) continue;
          most = o;
          largest = k;
        }
        if (rest == m || rest == 0 || rest >= min_quanta) return;
        offers(near.place(largest)) = most + rest;
        Kokkos::atomic_add(&offered(near(largest)), rest);
      });
}

/// t_ij of every pair: mass leaves the liquid; mass and momentum are on their way in `entering` and `momentum`.
void transfer(Device& d) {
  const Neighbors list(d.fluid_sample);
  const Entries<Quanta> offers = d.absorption_work.offer;
  const Entries<Quanta> mass = d.fluid.mass;
  const Entries<Real3> velocity = d.fluid.velocity;
  const Transfers transfers(d);
  const Quanta min_quanta = d.model.min_quanta;
  parallel(
      "drench::absorption::transfer", d.fluid.count, KOKKOS_LAMBDA(const Index i) {
        const NeighborRow near = list.row(i);
        const Quanta m = near.count > 0 ? mass(i) : 0;
        if (m <= 0) return;
        const Real3 v = velocity(i);
        Quanta rest = m;
        bool was_limited = false;
        for (Index k = 0; k < near.count; ++k) {
          const Quanta o = offers(near.place(k));
          if (o == 0) continue;
          const Index p = near(k);
          const double phi = transfers.share(p);
          if (phi < 1) was_limited = true;
          const Quanta t = limited(o, phi);
          transfers.give(p, o, t, v);
          rest -= t;
        }
        Quanta back = was_limited && rest > 0 && rest < min_quanta ? min_quanta - rest : 0;
        for (Index k = 0; k < near.count && back > 0; ++k) {
          const Quanta o = offers(near.place(k));
          if (o == 0) continue;
          const Index p = near(k);
          const Quanta t = limited(o, transfers.share(p)), cut = t < back ? t : back;
          transfers.take_back(p, t, cut, v);
          rest += cut;
          back -= cut;
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
  make_room(d.absorption_work.offer, "drench::absorption::offer", d.fluid_sample.entry.extent(0));
  prepare_transfers(d);
  place_samples(d);
  prepare(d);
  offer(d, info.dt);
  limit_inflow(d, d.model.has_saturation_control());
  transfer(d);
  const Delivery deliver(d);
  gather_rows<Arrival>("drench::absorption::deliver", d.nodes.count, d.nodes.sample_start, deliver, deliver);
  if (!d.model.has_emission()) remove_taken(d);
}

}  // namespace drench::kokkos_backend
