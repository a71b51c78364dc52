// Stage absorption (src/stages/absorption.hpp). Particles that are taken whole stay in the arrays with mass 0, because
// the neighbour lists name them; stage emission removes them, or this one at its end where there is none.

#include "cloth/wet_cloth.hpp"
#include "core/filled_rows.hpp"
#include "core/neighbor_search.hpp"
#include "porous/absorption_law.hpp"
#include "porous/faces.hpp"
#include "porous/flow_law.hpp"
#include "porous/permeation_law.hpp"
#include "porous/stages.hpp"
#include "porous/transfer.hpp"

namespace drench::kokkos_backend {
namespace {

/// s_p of every sample (a node with C_n = 0 counts 0), and what `offer` asks about it; nothing is on its way to any.
void prepare(const Constants& constants, Cloth& cloth, TransferWork& transfers, AbsorptionWork& work) {
  const auto samples = static_cast<std::size_t>(cloth.samples.count);
  make_room(work.position_saturation, "drench::absorption::position_saturation", samples);
  make_room(work.flow_capacity, "drench::absorption::flow_capacity", samples);
  const Entries<Real4> position_saturation = work.position_saturation, flow_capacity = work.flow_capacity;
  const Entries<const Real3> x = cloth.samples.position, flow = cloth.samples.flow_direction;
  const Entries<const Index> node = cloth.samples.node;
  const Entries<const Real> weight = cloth.samples.weight, capacity = cloth.samples.capacity;
  const NodeLiquid wet(constants, cloth);
  const Transfers exchange(cloth, transfers);
  parallel(
      "drench::absorption::saturation", cloth.samples.count, KOKKOS_LAMBDA(const Index p) {
        double sum = 0;
        for (int k = 0; k < 3; ++k) {
          const Index n = node(3 * p + k);
          if (wet.capacity(n) > 0) sum += double(weight(3 * p + k)) * wet.filling(n);
        }
        position_saturation(p) = {x(p), Real(sum)};
        flow_capacity(p) = {flow(p), capacity(p)};
        exchange.clear(p);
      });
}

/// What pressure takes from the liquid upstream of each sample: which way that is, and kg/s for each V W there.
void prepare_pull(const Constants& constants, const Cloth& cloth, const PermeationWork& permeation,
                  AbsorptionWork& work) {
  make_room(work.pull, "drench::absorption::pull", static_cast<std::size_t>(cloth.samples.count));
  const Entries<Real4> pull = work.pull;
  const Entries<const Real4> position_saturation = std::as_const(work).position_saturation;
  const Entries<const Real3> normal = cloth.samples.normal;
  const Entries<const Real> passing = cloth.samples.passing, area = cloth.samples.area, supply = permeation.supply;
  const Materials materials = sample_materials(cloth);
  const Real density = constants.rest_density;
  parallel(
      "drench::absorption::pull", cloth.samples.count, KOKKOS_LAMBDA(const Index p) {
        const Real u = passing(p);
        if (!laws::is_open(u, materials(p))) {
          pull(p) = {Real3{}, 0};
          return;
        }
        const Real part = laws::relative_permeability(position_saturation(p).w) / supply(p);
        pull(p) = {u < 0 ? normal(p) : Real(-1) * normal(p), density * area(p) * Kokkos::fabs(u) * part};
      });
}

}  // namespace

/// Of a sample one Real of eight (docs/dev/memory_estimate.md), and the offers.
MemoryEstimate absorption_bytes(const Sizing& s) {
  MemoryEstimate sum;
  if (!s.size.absorption || !s.size.liquid || !(s.size.fluid > 0)) return sum;
  sum.cloth = s.size.samples * 8 * s.real;                              // position_saturation, flow_capacity
  sum.lists = room_for_entries(s.entries.fluid_sample) * quanta_bytes;  // offer
  return sum;
}

namespace {

/// Demands of one particle.
struct Demands {
  Entries<Real4> position_saturation, flow_capacity, pull;
  Materials materials;
  Kernel kernel;
  double dt, q;
  Real h;
  bool controlled, single;  // one cloth

  Demands(const Constants& constants, const Cloth& fabric, AbsorptionWork& work, double step)
      : position_saturation(work.position_saturation),
        flow_capacity(work.flow_capacity),
        pull(work.pull),
        materials(sample_materials(fabric)),
        kernel(constants.kernel),
        dt(step),
        q(constants.quantum),
        h(constants.support),
        controlled(constants.model.has_saturation_control()),
        single(fabric.materials.extent(0) == 1) {}

  /// w_ij, quanta, of liquid at x with the volume V_i, m³.
  KOKKOS_INLINE_FUNCTION double operator()(const Real3& x, double volume, Index j) const {
    const Material& m = material(j);
    if (!m.porous) return 0;
    const Real4 at = position_saturation(j), flow_at = flow_capacity(j);
    const Real3 separation = at.xyz() - x;
    if (pull.exist() && m.conductance > 0) return of_permeable(m, separation, at.w, flow_at, volume, j);
    const Real cosine = laws::flow_cosine(separation, flow_at.xyz(), h);
    const Real cap =
        m.film_depth > 0 ? laws::film_cap(m.max_saturation, cosine) : laws::saturation_cap(m.max_saturation, cosine);
    const Real deficit = controlled ? cap - at.w : Real(1);
    if (!(deficit > 0)) return 0;
    return laws::absorption_demand(dt, m.absorption, flow_at.w / q, deficit, volume,
                                   laws::viscosity_laplacian(norm(separation), h));
  }

  /// Does pressure drain liquid through sample j?
  KOKKOS_INLINE_FUNCTION bool drains(Index j) const { return pull.exist() && material(j).conductance > 0; }

 private:
  KOKKOS_INLINE_FUNCTION const Material& material(Index j) const {
    return single ? materials.of_cloth(0) : materials(j);
  }
  /// The same of a fabric that pressure drives liquid through: it fills up to 1 by itself, unless it repels, and
  /// pressure does the rest.
  KOKKOS_INLINE_FUNCTION double of_permeable(const Material& m, const Real3& separation, Real saturation,
                                             const Real4& flow_at, double volume, Index j) const {
    const Real4 pulled = pull(j);
    const Real r = norm(separation);
    const bool upstream = dot(separation, pulled.xyz()) < 0;
    // Its film fills where nothing passes.
    const bool film = m.film_depth > 0 && dot(pulled.xyz(), pulled.xyz()) == 0;
    const Real cap = film ? laws::film_cap(m.max_saturation, laws::flow_cosine(separation, flow_at.xyz(), h)) : Real(1);
    const Real deficit = controlled ? cap - saturation : Real(1);
    double demand = 0;
    if (deficit > 0 && (upstream || !(m.entry_potential > 0)))
      demand =
          laws::absorption_demand(dt, m.absorption, flow_at.w / q, deficit, volume, laws::viscosity_laplacian(r, h));
    if (upstream) demand += dt / q * double(pulled.w) * volume * double(kernel.value(r));
    return demand;
  }
};

/// The offers of a particle: their sum, and the first of the largest with its place in the list.
struct Offers {
  Quanta sum = 0, most = 0;
  Index largest = 0;
  KOKKOS_INLINE_FUNCTION Offers& operator+=(const Offers& o) {
    sum += o.sum;
    if (o.most > most || (o.most == most && o.largest < largest)) {
      most = o.most;
      largest = o.largest;
    }
    return *this;
  }
};

/// o_ij of every pair, and Σ_i o_ij in `offered`.
void offer(const Constants& constants, const Fluid& fluid, const NeighborLists& lists, const Cloth& cloth,
           TransferWork& transfers, AbsorptionWork& work, double dt) {
  const Neighbors list(lists.fluid_sample);
  const Entries<Quanta> offers = work.offer;
  const Entries<const Real3> x = fluid.particles.position;
  const Entries<const Quanta> mass = fluid.particles.mass;
  const Entries<Quanta> offered = transfers.offered;
  const double q = constants.quantum, rho = constants.rest_density;
  const Quanta min_quanta = constants.model.min_quanta;
  const Demands demand(constants, cloth, work, dt);
  parallel_filled_rows(
      "drench::absorption::offer", lists.near_sheet, KOKKOS_LAMBDA(const Index i, const Index lane) {
        const NeighborRow near = list.row(i);
        const Quanta m = near.count > 0 ? mass(i) : 0;
        if (m <= 0) return;
        const Real3 at = x(i);
        const double volume = double(m) * q / rho;
        double all = 0;
        for (Index k = lane; k < near.count; k += row_lanes) {
          const double w = demand(at, volume, near(k));
          offers(near.index_of(k)) = Kokkos::bit_cast<Quanta>(w);  // kept there until it is an offer
          all += w;
        }
        all = sum_of_lanes(all);
        const double total = all > 0 ? laws::absorption_total(double(m), all) : 0;
        Offers own;
        bool drained = false;
        for (Index k = lane; k < near.count; k += row_lanes) {
          const double w = Kokkos::bit_cast<double>(offers(near.index_of(k)));
          const Quanta o = w > 0 ? static_cast<Quanta>(Kokkos::floor(total * (w / all))) : 0;
          offers(near.index_of(k)) = o;
          if (o == 0) continue;
          own += Offers{o, o, k};
          drained = drained || demand.drains(near(k));
          Kokkos::atomic_add(&offered(near(k)), o);
        }
        const Offers made = sum_of_lanes(own);
        const Quanta rest = m - made.sum;  // below 0 where rounding offers a quantum too many
        const Quanta least = any_of_lanes(drained) ? min_quanta / laws::drained_part : min_quanta;
        if (made.sum == 0 || rest == 0 || rest >= least || made.largest % row_lanes != lane) return;
        offers(near.index_of(made.largest)) = made.most + rest;
        Kokkos::atomic_add(&offered(near(made.largest)), rest);
      });
}

/// t_ij of every pair: mass leaves the liquid; mass and momentum are on their way in `entering` and `momentum`.
void transfer(const Constants& constants, Fluid& fluid, const NeighborLists& lists, const Cloth& cloth,
              TransferWork& transfers, AbsorptionWork& work) {
  const Neighbors list(lists.fluid_sample);
  const Entries<const Quanta> offers = std::as_const(work).offer;
  const Demands demand(constants, cloth, work, 0);
  const Entries<Quanta> mass = fluid.particles.mass;
  const Entries<const Real3> velocity = fluid.particles.velocity, x = fluid.particles.position,
                             sample = cloth.samples.position;
  const Transfers exchange(cloth, transfers);
  const Faces faces(cloth, transfers);
  const Quanta min_quanta = constants.model.min_quanta;
  parallel_filled_rows(
      "drench::absorption::transfer", lists.near_sheet, KOKKOS_LAMBDA(const Index i, const Index lane) {
        const NeighborRow near = list.row(i);
        const Quanta m = near.count > 0 ? mass(i) : 0;
        if (m <= 0) return;
        const Real3 v = velocity(i);
        Quanta given = 0;
        bool was_limited = false, drained = false;
        for (Index k = lane; k < near.count; k += row_lanes) {
          const Quanta o = offers(near.index_of(k));
          if (o == 0) continue;
          const Index p = near(k);
          const double phi = exchange.share(p);
          if (phi < 1) was_limited = true;
          drained = drained || demand.drains(p);
          const Quanta t = limited(o, phi);
          exchange.give(p, o, t, v);
          faces.count(p, x(i) - sample(p), t);
          given += t;
        }
        Quanta rest = m - sum_of_lanes(given);
        was_limited = any_of_lanes(was_limited);
        const Quanta least = any_of_lanes(drained) ? min_quanta / laws::drained_part : min_quanta;
        if (lane > 0) return;
        Quanta back = was_limited && rest > 0 && rest < least ? least - rest : 0;
        for (Index k = 0; k < near.count && back > 0; ++k) {
          const Quanta o = offers(near.index_of(k));
          if (o == 0) continue;
          const Index p = near(k);
          const Quanta t = limited(o, exchange.share(p)), cut = t < back ? t : back;
          exchange.take_back(p, t, cut, v);
          faces.count(p, x(i) - sample(p), -cut);
          rest += cut;
          back -= cut;
        }
        mass(i) = rest;
      });
}

/// What limits left of particle i's transfers: quanta that are cut from them, in the list's order.
struct Cut {
  Neighbors list;
  Entries<const Quanta> offers;
  Demands demand;
  Transfers exchange;
  Quanta min_quanta;

  KOKKOS_INLINE_FUNCTION Quanta transferred(Index p, Quanta offer) const {
    return offer == 0 ? 0 : limited(offer, exchange.share(p));
  }
  KOKKOS_INLINE_FUNCTION Quanta operator()(const NeighborRow& near, Quanta mass) const {
    Quanta rest = mass;
    bool was_limited = false, drained = false;
    for (Index k = 0; k < near.count; ++k) {
      const Quanta o = offers(near.index_of(k));
      if (o == 0) continue;
      was_limited = was_limited || exchange.share(near(k)) < 1;
      drained = drained || demand.drains(near(k));
      rest -= transferred(near(k), o);
    }
    const Quanta least = drained ? min_quanta / laws::drained_part : min_quanta;
    return was_limited && rest > 0 && rest < least ? least - rest : 0;
  }
};

/// The solute of what `transfer` is about to take; of a particle that is taken whole, what rounding leaves goes with
/// the largest part.
void take_solute(const Constants& constants, Fluid& fluid, const NeighborLists& lists, const Cloth& cloth,
                 TransferWork& transfers, AbsorptionWork& work) {
  const Cut cut{Neighbors(lists.fluid_sample), std::as_const(work).offer, Demands(constants, cloth, work, 0),
                Transfers(cloth, transfers), constants.model.min_quanta};
  const Entries<const Quanta> mass = std::as_const(fluid).particles.mass;
  const Entries<Quanta> solute = fluid.particles.solute;
  parallel(
      "drench::absorption::solute", fluid.particles.count, KOKKOS_LAMBDA(const Index i) {
        const NeighborRow near = cut.list.row(i);
        const Quanta m = mass(i), carried = solute(i);
        if (near.count == 0 || m <= 0 || carried == 0) return;
        Quanta back = cut(near, m), liquid = 0, left = carried, most = 0;
        Index largest = 0;
        for (Index k = 0; k < near.count; ++k) {
          const Quanta whole = cut.transferred(near(k), cut.offers(near.index_of(k)));
          const Quanta less = whole < back ? whole : back, t = whole - less;
          back -= less;
          if (t == 0) continue;
          const Quanta part = solute_part(carried, t, m);
          Kokkos::atomic_add(&cut.exchange.solute(near(k)), part);
          liquid += t;
          left -= part;
          if (t > most) most = t, largest = near(k);
        }
        if (liquid == m && left > 0) {
          Kokkos::atomic_add(&cut.exchange.solute(largest), left);
          left = 0;
        }
        solute(i) = left;
      });
}

/// Removes what was taken whole.
void remove_taken(Fluid& fluid, AbsorptionWork& work) {
  make_room_for_one(work.taken, "drench::absorption::taken");
  const Entries<const Quanta> mass = fluid.particles.mass;
  Kokkos::parallel_reduce(
      "drench::absorption::taken", range(fluid.particles.count),
      KOKKOS_LAMBDA(const Index i, Index& sum) { sum += mass(i) > 0 ? 0 : 1; }, work.taken);
  exec().fence("drench::absorption::taken");
  fluid.particles.compact({}, fluid.particles.count - work.taken());
}

}  // namespace

void absorption(const Constants& constants, Fluid& fluid, const NeighborLists& lists, Cloth& cloth,
                TransferWork& transfers, const PermeationWork& permeation, AbsorptionWork& work, const StepInfo& info) {
  cloth.soaked.advance();
  if (fluid.particles.total == 0 || cloth.samples.count == 0) return;
  make_room(work.offer, "drench::absorption::offer", lists.fluid_sample.entry.extent(0));
  prepare_transfers(constants, cloth, transfers);
  place_samples(cloth);
  prepare(constants, cloth, transfers, work);
  if (constants.model.has_permeation()) prepare_pull(constants, cloth, permeation, work);
  offer(constants, fluid, lists, cloth, transfers, work, info.dt);
  fluid.exchange.add_up(transfers.offered, cloth.samples.count);
  limit_inflow(cloth, transfers, constants.model.has_saturation_control());
  clear_faces(cloth, transfers);
  if (constants.model.has_solute()) take_solute(constants, fluid, lists, cloth, transfers, work);
  transfer(constants, fluid, lists, cloth, transfers, work);
  fluid.exchange.add_up(transfers.entering, cloth.samples.count);
  fluid.exchange.add_up(transfers.momentum, 3 * cloth.samples.count);
  if (transfers.front.exists()) fluid.exchange.add_up(transfers.front, cloth.samples.count);
  count_taken(cloth, transfers);
  if (constants.model.has_solute()) {
    fluid.exchange.add_up(transfers.solute, cloth.samples.count);
    const SoluteDelivery dissolve(cloth, transfers);
    gather_rows<SoluteArrival>("drench::absorption::deliver_solute", cloth.nodes.count, cloth.nodes.sample_start,
                               dissolve, dissolve);
  }
  const Delivery deliver(constants, transfers, cloth, info.dt);
  gather_rows<Arrival>("drench::absorption::deliver", cloth.nodes.count, cloth.nodes.sample_start, deliver, deliver);
  if (!constants.model.has_emission()) remove_taken(fluid, work);
}

}  // namespace drench::kokkos_backend
