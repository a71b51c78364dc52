// Stage diffusion (src/stages/diffusion.hpp). Two kernels over the nodes a sub-step: each node computes the flows of
// its own pairs, so that both of a pair's come to the same number.

#include "porous/diffusion.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "base/stop_request.hpp"
#include "cloth/wet_cloth.hpp"
#include "core/gather.hpp"
#include "core/host_copy.hpp"
#include "pipeline/substeps.hpp"
#include "porous/contact_wicking.hpp"
#include "porous/diffusion_law.hpp"
#include "porous/emission_law.hpp"
#include "porous/stages.hpp"
#include "porous/transfer.hpp"

namespace drench::kokkos_backend {
namespace {

/// The model's pairs with their conductances, once.
void upload_pairs(const Constants& constants, Cloth& cloth, DiffusionWork& work) {
  if (work.pair.extent(0) > 0) return;
  const FabricPairs& fabric = constants.model.fabric;
  std::vector<double> conductance(fabric.weight.size());
  const std::vector<double>& capacity = constants.model.samples.node_capacity;
  for (std::size_t e = 0; e < conductance.size(); ++e) {
    const auto i = static_cast<std::size_t>(fabric.nodes[e][0]), j = static_cast<std::size_t>(fabric.nodes[e][1]);
    const ClothMaterial& c = constants.model.cloths[static_cast<std::size_t>(constants.model.mesh.node_cloth[i])];
    if (capacity[i] > 0 && capacity[j] > 0)
      conductance[e] =
          constants.model.rest_density * (1 - c.solid_fraction) * c.thickness * c.diffusivity * fabric.weight[e];
  }
  work.pairs = static_cast<Index>(conductance.size());
  work.pair = to_device<Index>("drench::diffusion::pair", flat(fabric.nodes));
  work.conductance = to_device<double>("drench::diffusion::conductance", conductance);
  work.node_start = to_device<Index>("drench::diffusion::node_start", fabric.of_node.start);
  work.node_item = to_device<Index>("drench::diffusion::node_item", fabric.of_node.item);
  if (constants.model.has_films()) {
    work.film = to_device<double>("drench::diffusion::film", fabric.film);
    work.hem = to_device<std::uint8_t>("drench::diffusion::hem", fabric.hem);
    make_room(cloth.nodes.film_pull, "drench::node_film_pull", static_cast<std::size_t>(cloth.nodes.count));
  }
  if (constants.model.has_suction())
    make_room(work.suction, "drench::diffusion::suctions", static_cast<std::size_t>(cloth.nodes.count));
  if (constants.model.has_narrowing()) {
    work.rest_square = to_device<double>("drench::diffusion::rest_square", fabric.rest_square);
    make_room(work.narrowing, "drench::diffusion::narrowing", static_cast<std::size_t>(cloth.nodes.count));
  }
  allocate_zeros(work.drop, "drench::diffusion::drop", conductance.size());
  allocate_zeros(work.flow, "drench::diffusion::flow", conductance.size());
  const auto nodes = static_cast<std::size_t>(cloth.nodes.count);
  allocate_zeros(work.out_share, "drench::diffusion::out_share", nodes);
  allocate_zeros(work.in_share, "drench::diffusion::in_share", nodes);
  if (constants.model.has_solute())
    allocate_zeros(work.solute_flow, "drench::diffusion::solute_flow", conductance.size());
}

}  // namespace

MemoryEstimate diffusion_bytes(const Sizing& s) {
  MemoryEstimate sum;
  if (!s.size.diffusion) return sum;
  sum.cloth = s.size.fabric_pairs * (4 * index_bytes + 2 * double_bytes + quanta_bytes);  // and node_item
  sum.cloth += s.size.nodes * (2 * double_bytes + index_bytes);                           // shares, node_start
  if (s.size.solute) sum.cloth += s.size.fabric_pairs * quanta_bytes;
  if (s.size.suction) sum.cloth += s.size.nodes * sizeof(laws::NodeSuction);
  if (s.size.narrowing) sum.cloth += (s.size.fabric_pairs + s.size.nodes) * double_bytes;
  if (s.size.films) sum.cloth += s.size.fabric_pairs * double_bytes + s.size.nodes * (s.real + 1);  // film_pull, hem
  if (s.size.moving_cloth) sum.cloth += s.size.nodes * 2 * sizeof(Double3);                         // velocities
  return sum;
}

namespace {

/// What the kernels see of the pairs.
struct NodePairs {
  Entries<const Index> pair, start, item;
  Entries<const double> conductance, film, narrowing;  // narrowing: ν per node; null unless pores narrow
  Entries<double> drop;
  Entries<const Quanta> ceiling;
  Entries<const laws::NodeSuction> suction;  // null unless liquid flows by it
  NodeLiquid wet;
  Materials materials;

  NodePairs(const Constants& constants, const Cloth& fabric, DiffusionWork& work)
      : pair(work.pair),
        start(work.node_start),
        item(work.node_item),
        conductance(work.conductance),
        film(work.film),
        narrowing(work.narrowing),
        drop(work.drop),
        ceiling(fabric.nodes.max_quanta),
        suction(work.suction),
        wet(constants, fabric),
        materials(node_materials(fabric)) {}

  /// Of pair e, quanta, > 0 to its first node: what the law wants to flow, `scale` = Δt/q. A dry node gives nothing.
  KOKKOS_INLINE_FUNCTION Quanta offer(Index e, double scale) const {
    if (!(conductance(e) > 0)) return 0;
    const Index i = pair(2 * e), j = pair(2 * e + 1);
    const bool dry_i = wet.liquid(i) == 0, dry_j = wet.liquid(j) == 0;
    if (dry_i && dry_j) return 0;
    const Material& m = materials(i);
    double flux = m.by_suction
                      ? suction_flux(e, i, j)
                      : laws::retained_flux(conductance(e), wet.pore_filling(i, m), wet.pore_filling(j, materials(j)),
                                            drop(e), m.mobility_exponent, m.retention);
    if (wet.pores.exist()) flux += conductance(e) * (squeezed_out(j) - squeezed_out(i));
    if (film.exist()) flux += film_flux(e, m, drop(e) > 0 ? j : i);
    if (flux > 0 ? dry_j : dry_i) return 0;
    const Quanta o = offered(Kokkos::abs(flux) * scale);
    return flux > 0 ? o : -o;
  }
  /// Of pair e, kg/s, by the suctions of both nodes.
  KOKKOS_INLINE_FUNCTION double suction_flux(Index e, Index i, Index j) const {
    const Material& m = materials(i);
    const laws::NodeSuction here = suction(i), there = suction(j);
    const double conducting = conductance(e) * thinning(i, j), drive = (there.held - here.held) + drop(e);
    if (!(m.suction.wetting.large > 0))
      return laws::held_flux(conducting, wet.pore_filling(i, m), wet.pore_filling(j, materials(j)), here.held,
                             there.held, drop(e), m.mobility_exponent);
    return conducting * drive *
           laws::parallel_mobility(m.suction.wetting, here.filling, there.filling,
                                   drive > 0 ? there.filling : here.filling, m.mobility_exponent);
  }
  /// Factor on the conductance of a pair whose pores are narrowed, 1.
  KOKKOS_INLINE_FUNCTION double thinning(Index i, Index j) const {
    if (!narrowing.exist()) return 1;
    return 2 / (narrowing(i) * narrowing(i) + narrowing(j) * narrowing(j));
  }
  /// What pressure has left no room for at a node, of what its pores hold under it, 1.
  KOKKOS_INLINE_FUNCTION double squeezed_out(Index n) const {
    const Quanta above = wet.liquid(n) - ceiling(n);
    return above > 0 && wet.pores(n) > 0 ? double(above) * wet.quantum / wet.pores(n) : 0;
  }
  /// Of the film of pair e, whose first node is of material m; it leaves the upper node.
  KOKKOS_INLINE_FUNCTION double film_flux(Index e, const Material& m, Index upper) const {
    // What hangs at a hem is thicker.
    const double delta = smaller(double(materials(upper).film_depth) * wet.beyond(upper), 2 * double(m.film));
    return laws::film_flux(film(e) * double(m.film_flow), delta, drop(e) * double(m.capillary_height));
  }
};

/// Which curve each node is on in this sub-step.
void turn_nodes(const Constants& constants, Cloth& cloth) {
  const NodeLiquid wet(constants, cloth);
  const Materials materials = node_materials(cloth);
  const Entries<Real> scanning = cloth.nodes.scanning, extreme = cloth.nodes.extreme;
  parallel(
      "drench::diffusion::turn", cloth.nodes.count, KOKKOS_LAMBDA(const Index n) {
        const Material& m = materials(n);
        if (!(m.suction.ratio > 1) || !(wet.capacity(n) > 0)) return;
        const laws::Scan scan = m.suction.next({double(scanning(n)), double(extreme(n))}, wet.pore_filling(n, m));
        scanning(n) = Real(scan.curve);
        extreme(n) = Real(scan.extreme);
      });
}

/// What each node draws with in this sub-step, with hysteresis on the curve that it is on.
void set_suctions(const Constants& constants, Cloth& cloth, DiffusionWork& work) {
  const NodeLiquid wet(constants, cloth);
  const Materials materials = node_materials(cloth);
  const Entries<const Real> scanning = std::as_const(cloth).nodes.scanning;
  const Entries<const double> narrowing = work.narrowing;
  const Entries<laws::NodeSuction> suction = work.suction;
  parallel(
      "drench::diffusion::suction", cloth.nodes.count, KOKKOS_LAMBDA(const Index n) {
        const Material& m = materials(n);
        if (!m.by_suction || !(wet.capacity(n) > 0)) return;
        const double s = wet.pore_filling(n, m), curve = scanning.exist() ? double(scanning(n)) : 1;
        const double held = m.suction.held(s, curve), finer = narrowing.exist() ? narrowing(n) : 1;
        suction(n).held = finer == 1 ? held : 1 - finer * (1 - held);
        if (m.suction.wetting.large > 0) suction(n).filling = m.suction.filling(s);
      });
}

/// Of a node, quanta.
struct Flows {
  Quanta in = 0, out = 0;
  KOKKOS_INLINE_FUNCTION Flows& operator+=(const Flows& o) {
    in += o.in;
    out += o.out;
    return *this;
  }
};

/// φ of every node; the offers in `flow`. In the first sub-step also the velocities in double: they are rounded once a
/// step and not once a sub-step.
void limit(const Constants& constants, Cloth& cloth, DiffusionWork& work, double dt, bool take_velocity) {
  const NodePairs pairs(constants, cloth, work);
  const Entries<Quanta> flow = work.flow;
  const Entries<const Quanta> ceiling = cloth.nodes.max_quanta;
  const Entries<double> out_share = work.out_share, in_share = work.in_share;
  const Entries<const Real3> v = cloth.nodes.velocity;
  const Entries<Double3> wide = work.velocity;
  const double scale = dt / constants.quantum;
  gather_rows<Flows>(
      "drench::diffusion::limit", cloth.nodes.count, pairs.start,
      KOKKOS_LAMBDA(const Index k) {
        const bool first = pairs.item(k) % 2 == 0;
        const Quanta o = pairs.offer(pairs.item(k) / 2, scale);
        if (first) flow(pairs.item(k) / 2) = o;
        const Quanta gain = first ? o : -o;
        return gain > 0 ? Flows{gain, 0} : Flows{0, -gain};
      },
      KOKKOS_LAMBDA(const Index n, const Flows& sum) {
        out_share(n) = outflow_fraction(pairs.wet.liquid(n), sum.out);
        in_share(n) = inflow_fraction(ceiling(n), pairs.wet.liquid(n), sum.in);
        if (take_velocity) wide(n) = widen(v(n));
      });
}

/// Does liquid diffuse in cloth that moves? If not, no velocity is touched.
bool carries_momentum(const Model& m) {
  return m.any_cloth([](const ClothMaterial& c) { return c.dynamics && c.wicks(); });
}

void make_room_for_velocities(const Cloth& cloth, DiffusionWork& work) {
  make_room(work.velocity, "drench::diffusion::velocity", static_cast<std::size_t>(cloth.nodes.count));
  make_room(work.next_velocity, "drench::diffusion::next_velocity", static_cast<std::size_t>(cloth.nodes.count));
}

void give_velocities(Cloth& cloth, const DiffusionWork& work) {
  const Entries<Real3> v = cloth.nodes.velocity;
  const Entries<const Double3> wide = work.velocity;
  parallel(
      "drench::diffusion::give_velocity", cloth.nodes.count, KOKKOS_LAMBDA(const Index n) { v(n) = narrow(wide(n)); });
}

/// By a node in a sub-step.
struct Received {
  Quanta gain = 0;
  Double3 push;  // Σ_in t (v_donor − v_n), quanta · m/s
  KOKKOS_INLINE_FUNCTION Received& operator+=(const Received& o) {
    gain += o.gain;
    push = add(push, o.push);
    return *this;
  }
};

/// The solute goes along with what `transfer` is about to move, at the donor's concentration.
void transfer_solute(Cloth& cloth, DiffusionWork& work) {
  const Entries<const Index> pair = work.pair, start = work.node_start, item = work.node_item;
  const Entries<const Quanta> flow = std::as_const(work).flow, liquid = std::as_const(cloth).nodes.liquid;
  const Entries<const double> out_share = work.out_share, in_share = work.in_share;
  const Entries<Quanta> solute_flow = work.solute_flow, solute = cloth.nodes.solute;
  parallel(
      "drench::diffusion::solute", work.pairs, KOKKOS_LAMBDA(const Index e) {
        const Quanta o = flow(e);
        const Index first = pair(2 * e), second = pair(2 * e + 1), donor = o > 0 ? second : first,
                    receiver = o > 0 ? first : second;
        const Quanta t = o == 0 ? 0 : limited(o > 0 ? o : -o, smaller(out_share(donor), in_share(receiver)));
        const Quanta part = solute_part(solute(donor), t, liquid(donor));
        solute_flow(e) = o > 0 ? part : -part;
      });
  gather_rows<SoluteArrival>(
      "drench::diffusion::solute_gain", cloth.nodes.count, start,
      KOKKOS_LAMBDA(const Index k) {
        const Quanta gain = solute_flow(item(k) / 2);
        return SoluteArrival{item(k) % 2 == 0 ? gain : -gain};
      },
      KOKKOS_LAMBDA(const Index n, const SoluteArrival& sum) { solute(n) += sum.gain; });
}

/// `give_velocity`: the new velocities are the step's last, and go to the nodes.
void transfer(const Constants& constants, Cloth& cloth, DiffusionWork& work, bool with_momentum, bool give_velocity) {
  const Entries<const Index> pair = work.pair, start = work.node_start, item = work.node_item;
  const Entries<const Quanta> flow = work.flow;
  const Entries<Quanta> liquid = cloth.nodes.liquid;
  const Entries<const double> out_share = work.out_share, in_share = work.in_share;
  const Entries<const Double3> v = work.velocity;
  const Entries<Double3> next = work.next_velocity;
  const Entries<Real3> velocity = cloth.nodes.velocity;
  const Entries<const Real> solid = cloth.nodes.solid_mass;
  const Entries<const std::uint8_t> fixed = cloth.nodes.fixed;
  const double q = constants.quantum;
  gather_rows<Received>(
      "drench::diffusion::transfer", cloth.nodes.count, start,
      KOKKOS_LAMBDA(const Index k) {
        const Index e = item(k) / 2, n = pair(item(k)), other = pair(item(k) ^ 1);
        const Quanta o = item(k) % 2 == 0 ? flow(e) : -flow(e);
        if (o == 0) return Received{};
        const Quanta t = limited(
            o > 0 ? o : -o, o > 0 ? smaller(out_share(other), in_share(n)) : smaller(out_share(n), in_share(other)));
        if (!with_momentum || o < 0 || t == 0) return Received{o > 0 ? t : -t, {}};
        return Received{t, times(double(t), minus(v(other), v(n)))};
      },
      KOKKOS_LAMBDA(const Index n, const Received& sum) {
        liquid(n) += sum.gain;
        if (!with_momentum) return;
        const double mass = double(solid(n)) + q * double(liquid(n));
        const Double3 after = fixed(n) || !(mass > 0) ? v(n) : add(v(n), times(q / mass, sum.push));
        if (give_velocity)
          velocity(n) = narrow(after);
        else
          next(n) = after;
      });
  if (with_momentum) std::swap(work.velocity, work.next_velocity);
}

}  // namespace

/// ν of every node, from the strain of the pairs around it (docs/theory/porous.md, Eq. 53).
void narrow_pores(const Constants& constants, Cloth& cloth, DiffusionWork& work) {
  const NodePairs pairs(constants, cloth, work);
  const Entries<const double> rest = work.rest_square;
  const Entries<double> narrowing = work.narrowing;
  const Entries<const Real3> x = cloth.nodes.position;
  parallel(
      "drench::diffusion::narrow", cloth.nodes.count, KOKKOS_LAMBDA(const Index n) {
        double now = 0, before = 0;
        for (Index k = pairs.start(n); k < pairs.start(n + 1); ++k) {
          const Index e = pairs.item(k) / 2;
          if (!(rest(e) > 0)) continue;
          const Double3 apart = minus(widen(x(pairs.pair(2 * e))), widen(x(pairs.pair(2 * e + 1))));
          now += pairs.conductance(e) * inner(apart, apart);
          before += pairs.conductance(e) * rest(e);
        }
        narrowing(n) =
            laws::narrowing_at(double(pairs.materials(n).pore_narrowing), before > 0 ? now / before - 1 : 0.0);
      });
}

void launch_diffusion_rate(const Constants& constants, Cloth& cloth, DiffusionWork& work) {
  if (cloth.samples.count == 0) return;
  upload_pairs(constants, cloth, work);
  if (work.rate.is_of(cloth.moved)) return;
  make_room_for_one(work.rate.largest, "drench::diffusion::largest_rate");
  if (constants.model.has_narrowing()) narrow_pores(constants, cloth, work);
  const NodePairs pairs(constants, cloth, work);
  const Entries<const Real3> x = cloth.nodes.position;
  const Real gravity = norm(constants.gravity);
  const Entries<const std::uint8_t> hem = work.hem;
  const Entries<Real> pull = cloth.nodes.film_pull;
  const double density = constants.rest_density;
  const Real3 down = gravity > 0 ? (1 / gravity) * constants.gravity : Real3{};
  Kokkos::parallel_reduce(
      "drench::diffusion::rate", range(cloth.nodes.count),
      KOKKOS_LAMBDA(const Index n, double& largest) {
        const Material& m = pairs.materials(n);
        double rate = 0, steepness = 0;  // 1/s, kg/s at first; Σ ω Δz², m²
        for (Index k = pairs.start(n); k < pairs.start(n + 1); ++k) {
          const Index e = pairs.item(k) / 2, i = pairs.pair(2 * e), j = pairs.pair(2 * e + 1);
          const double drop = double(dot(x(i) - x(j), down) / pairs.materials(i).capillary_height);
          if (i == n) pairs.drop(e) = drop;
          double most = m.most_mobility, height = Kokkos::abs(drop);
          if (pairs.narrowing.exist()) {
            most *= larger(pairs.narrowing(i), pairs.narrowing(j));
            height += Kokkos::abs(pairs.narrowing(i) - pairs.narrowing(j));
          }
          rate += pairs.conductance(e) * pairs.thinning(i, j) * (most + m.height_mobility * height);
          if (!pairs.film.exist()) continue;
          const double fall = drop * double(pairs.materials(i).capillary_height);
          rate +=
              laws::steepest_film(pairs.film(e) * double(m.film_flow), 2 * double(m.film), double(m.film_depth), fall);
          steepness += pairs.film(e) * fall * fall;
        }
        if (pairs.film.exist()) {
          const double area = pairs.wet.capacity(n) / (density * double(m.film_depth));
          const double level = 1 - smaller(1.0, steepness / (2 * area));  // cos² of its slope
          pull(n) = hem(n) ? laws::at_hem : Real(gravity * gravity * level);
        }
        rate = pairs.wet.capacity(n) > 0 ? rate / pairs.wet.room(n) : 0.0;
        if (rate > largest) largest = rate;
      },
      Kokkos::Max<double, Kokkos::SharedHostPinnedSpace>(work.rate.largest));
  work.rate.set_made_from(cloth.moved);
  work.rate.waited = false;
}

void diffusion(const Constants& constants, const NeighborLists& lists, Cloth& cloth, DiffusionWork& work,
               ContactWork& contacts, ReservoirWork& reservoirs, Accounts& accounts, const StepInfo& info,
               StepReport& report) {
  cloth.soaked.advance();
  if (cloth.samples.count == 0 || !(info.dt > 0)) return;
  launch_diffusion_rate(constants, cloth, work);
  if (!work.rate.waited) exec().fence("drench::diffusion::rate");
  work.rate.waited = true;
  const int substeps = diffusion_substeps_within_limit(std::max(0.0, work.rate.largest()), info, report);
  const double dt = info.dt / substeps;
  const bool layers = constants.model.has_contact_wicking(), with_momentum = carries_momentum(constants.model);
  if (layers) find_contacts(constants, lists, cloth, contacts, dt, with_momentum);
  if (with_momentum) make_room_for_velocities(cloth, work);
  for (int k = 0; k < substeps; ++k) {
    stop_if_requested();
    const bool last = k + 1 == substeps;
    if (constants.model.has_hysteresis()) turn_nodes(constants, cloth);
    if (constants.model.has_suction()) set_suctions(constants, cloth, work);
    limit(constants, cloth, work, dt, with_momentum && k == 0);
    if (constants.model.has_reservoirs()) open_reservoirs(constants, reservoirs, work.in_share);
    if (constants.model.has_solute()) transfer_solute(cloth, work);
    transfer(constants, cloth, work, with_momentum, last && !layers);
    if (layers) wick_through_contacts(constants, cloth, work, contacts, reservoirs, dt, with_momentum);
    if (!last && constants.model.has_reservoirs()) reservoir(constants, cloth, reservoirs, accounts);
  }
  if (with_momentum && layers) give_velocities(cloth, work);
  report.diffusion_substeps = substeps;
}

}  // namespace drench::kokkos_backend
