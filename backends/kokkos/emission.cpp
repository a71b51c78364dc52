// Stage emission (src/stages/emission.hpp). The letters (a) to (e) are those of its law; (d) is in emission_particles.cpp.
// The host waits once: for the number of new particles, or, as long as nothing is ripe, for that news.

#include "laws/emission.hpp"

#include "emission_particles.hpp"
#include "primitives/transfer.hpp"
#include "virtual_pressure.hpp"

namespace drench::kokkos_backend {
namespace {

void prepare(Device& d) {
  auto& w = d.emission_work;
  const auto samples = static_cast<std::size_t>(d.samples.count);
  make_room(w.share, "drench::emission::share", 3 * samples);
  make_room(w.total, "drench::emission::total", samples);
  make_room(w.rest, "drench::emission::rest", samples);
  make_room(w.room, "drench::emission::room", samples);
  make_room(w.velocity, "drench::emission::velocity", samples);
  make_room(w.blocked, "drench::emission::blocked", samples);
  make_room(w.layers, "drench::emission::layers", samples);
  if (d.boundary.count > 0 && d.model.has_direction())
    make_room(w.direction, "drench::emission::direction", samples);
  else
    w.direction = d.samples.flow_direction;
  if (w.any.extent(0) == 0) {
    w.any = Array<int>("drench::emission::any", 2);
    w.counts = decltype(w.counts)(Kokkos::ViewAllocateWithoutInitializing("drench::emission::counts"));
    w.new_particles =
        decltype(w.new_particles)(Kokkos::ViewAllocateWithoutInitializing("drench::emission::new_particles"));
  }
  prepare_transfers(d);
}

/// What of a node's liquid is ripe now, and the shares of its samples in that.
struct Ripening {
  Entries<Quanta> liquid, ripe, capacity;
  Entries<Index> cloth;
  Entries<Material> materials;
  double dt, spacing;

  Ripening(const Device& d, double step)
      : liquid(d.nodes.liquid),
        ripe(d.nodes.ripe),
        capacity(d.nodes.capacity_quanta),
        cloth(d.nodes.cloth),
        materials(d.materials),
        dt(step),
        spacing(d.spacing) {}

  /// May there be any?
  KOKKOS_INLINE_FUNCTION bool any(Index n) const { return ripe(n) > 0 || liquid(n) > capacity(n); }
  KOKKOS_INLINE_FUNCTION Quanta operator()(Index n) const {
    const Quanta excess = liquid(n) > capacity(n) ? liquid(n) - capacity(n) : 0;
    const Quanta kept = ripe(n) < excess ? ripe(n) : excess;
    if (kept == excess) return kept;
    const double part = laws::ripening(materials(cloth(n)).emission_velocity, dt, spacing);
    return kept + static_cast<Quanta>(Kokkos::floor(part * double(excess - kept)));
  }
};

/// Whether anything may be ripe, and how many particles are empty.
EmissionCounts look(Device& d) {
  const Ripening ripening(d, 0);
  const Entries<Quanta> mass = d.fluid.mass;
  const Index nodes = d.nodes.count, particles = d.fluid.count;
  const auto counts = d.emission_work.counts;
  Kokkos::parallel_reduce(
      "drench::emission::ripe", Range(0, nodes > particles ? nodes : particles),
      KOKKOS_LAMBDA(const Index k, EmissionCounts& sum) {
        if (k < nodes && ripening.any(k)) ++sum.ripe;
        if (k < particles && mass(k) == 0) ++sum.empty;
      },
      counts);
  ExecSpace().fence("drench::emission::ripe");
  return counts();
}

/// e_p, where liquid leaves.
struct Direction {
  Entries<Real3> flow;
  Real3 gravity;
  Real gravity_size;

  explicit Direction(const Device& d)
      : flow(d.samples.flow_direction), gravity(d.gravity), gravity_size(norm(d.gravity)) {}
  KOKKOS_INLINE_FUNCTION Real3 operator()(Index p, const VirtualPressure& pressure) const {
    if (pressure.count(p) == 0 || !(dot(flow(p), flow(p)) > 0)) return flow(p);
    const Real epsilon =
        laws::flow_regularisation(gravity_size, pressure.materials(pressure.cloth(p)).virtual_pressure);
    return laws::flow_direction(pressure(p) + gravity, epsilon);
  }
};

/// e_p, E_pk, E_p and v^e_p; nothing is on its way.
void shares(Device& d, double dt) {
  const auto& w = d.emission_work;
  const Entries<Quanta> share = w.share, total = w.total, rest = w.rest, room = w.room;
  const Entries<Real3> leaving_velocity = w.velocity, direction = w.direction, node_velocity = d.nodes.velocity,
                       flow = d.samples.flow_direction;
  const Entries<double> weight_sum = d.nodes.weight_sum;
  const Entries<int> any = w.any;
  const Ripening ripened(d, dt);
  const Transfers transfers(d);
  const bool directed = d.model.has_direction(), solids = directed && d.boundary.count > 0;
  const Direction outward(d);
  const VirtualPressure pressure(d);
  const Entries<Index> cloth = d.samples.cloth;
  parallel(
      "drench::emission::share", d.samples.count, KOKKOS_LAMBDA(const Index p) {
        transfers.clear(p);
        room(p) = 0;
        const bool emits = ripened.materials(cloth(p)).porous && (!directed || dot(flow(p), flow(p)) > 0);
        Quanta sum = 0;
        double vx = 0, vy = 0, vz = 0;
        bool ripe = false;
        for (int k = 0; k < 3; ++k) {
          const Index n = transfers.node(3 * p + k);
          ripe = ripe || ripened.any(n);
          const Quanta e = emits ? laws::ripe_share(transfers.weight(3 * p + k), ripened(n), weight_sum(n)) : 0;
          share(3 * p + k) = e;
          sum += e;
          vx += double(e) * double(node_velocity(n).x);
          vy += double(e) * double(node_velocity(n).y);
          vz += double(e) * double(node_velocity(n).z);
        }
        total(p) = sum;
        rest(p) = sum;
        const double inverse = sum > 0 ? 1 / double(sum) : 0;
        leaving_velocity(p) = {Real(inverse * vx), Real(inverse * vy), Real(inverse * vz)};
        if (ripe && any(0) == 0) Kokkos::atomic_store(&any(0), 1);
        if (sum > 0 && solids) direction(p) = outward(p, pressure);
      });
}

/// What (a) asks about a liquid particle and a sample near it.
struct Reach {
  Neighbors list;
  Entries<Real3> liquid, sample, flow;
  Entries<Index> cloth;
  Entries<Material> materials;
  Entries<Quanta> mass, total;
  Entries<int> any;
  Real support;
  Quanta full;

  explicit Reach(const Device& d)
      : list(d.fluid_sample),
        liquid(d.fluid.position),
        sample(d.samples.position),
        flow(d.emission_work.direction),
        cloth(d.samples.cloth),
        materials(d.materials),
        mass(d.fluid.mass),
        total(d.emission_work.total),
        any(d.emission_work.any),
        support(d.support),
        full(d.model.max_quanta) {}
  KOKKOS_INLINE_FUNCTION bool takes(Index j) const { return any(0) != 0 && mass(j) > 0 && mass(j) < full; }
  /// Does sample p offer to particle j?
  KOKKOS_INLINE_FUNCTION bool offers(Index p, Index j) const {
    return total(p) > 0 && laws::in_cone(liquid(j) - sample(p), flow(p), materials(cloth(p)).emission_cosine, support);
  }
};

/// Which places of a particle's list offer to it: those beyond 64 are asked again.
struct Offering {
  std::uint64_t first = 0;
  KOKKOS_INLINE_FUNCTION void add(Index k) {
    if (k < 64) first |= std::uint64_t{1} << k;
  }
  /// May place k be one?
  KOKKOS_INLINE_FUNCTION bool at(Index k) const { return k >= 64 || (first >> k & 1) != 0; }
};

/// (a): the room that each sample sees, then what each particle accepts; rest becomes E′_p.
void give_to_liquid(Device& d) {
  const auto& w = d.emission_work;
  const Reach reach(d);
  const Entries<Quanta> room = w.room, rest = w.rest;
  const Entries<Real3> leaving_velocity = w.velocity, velocity = d.fluid.velocity;
  parallel(
      "drench::emission::room", d.fluid.count, KOKKOS_LAMBDA(const Index j) {
        if (!reach.takes(j)) return;
        const Quanta own_room = reach.full - reach.mass(j);
        const NeighborRow near = reach.list.row(j);
        for (Index k = 0; k < near.count; ++k) {
          const Index p = near(k);
          if (reach.offers(p, j)) Kokkos::atomic_add(&room(p), own_room);
        }
      });
  parallel(
      "drench::emission::give_to_liquid", d.fluid.count, KOKKOS_LAMBDA(const Index j) {
        if (!reach.takes(j)) return;
        const Quanta mass = reach.mass(j), own_room = reach.full - mass;
        const NeighborRow near = reach.list.row(j);
        Offering offering;
        Quanta offered = 0;
        for (Index k = 0; k < near.count; ++k) {
          const Index p = near(k);
          if (!reach.offers(p, j)) continue;
          offering.add(k);
          offered += floor_ratio(reach.total(p), own_room, room(p));
        }
        if (offered == 0) return;
        Quanta gained = 0;
        std::int64_t px = 0, py = 0, pz = 0;
        for (Index k = 0; k < near.count; ++k) {
          if (!offering.at(k)) continue;
          const Index p = near(k);
          if (k >= 64 && !reach.offers(p, j)) continue;
          const Quanta t = laws::accepted_offer(floor_ratio(reach.total(p), own_room, room(p)), offered, own_room);
          if (t == 0) continue;
          gained += t;
          const Real3 v = leaving_velocity(p);
          px += fixed_momentum(t, v.x);
          py += fixed_momentum(t, v.y);
          pz += fixed_momentum(t, v.z);
          Kokkos::atomic_add(&rest(p), -t);
        }
        if (gained == 0) return;
        const double before = double(mass), after = before + double(gained), unit = 1 / momentum_steps;
        const Real3 v = velocity(j);
        velocity(j) = {Real((before * double(v.x) + unit * double(px)) / after),
                       Real((before * double(v.y) + unit * double(py)) / after),
                       Real((before * double(v.z) + unit * double(pz)) / after)};
        reach.mass(j) = mass + gained;
      });
}

/// For the host: how many particles are empty, and whether anything is ripe. By itself: within a reduction of Kokkos loops over
/// neighbours run at half the speed.
void count(Device& d) {
  const Entries<Quanta> mass = d.fluid.mass;
  const Entries<int> any = d.emission_work.any;
  const Index particles = d.fluid.count;
  Kokkos::parallel_reduce(
      "drench::emission::count", Range(0, particles > 0 ? particles : 1),
      KOKKOS_LAMBDA(const Index j, EmissionCounts& counts) {
        if (j == 0) counts.ripe = any(0);
        if (j < particles && mass(j) == 0) ++counts.empty;
      },
      d.emission_work.counts);
}

/// (b) and the first pass of (c). blocked: 1 for samples that see a solid in their cone, 2 for others that see their own layer
/// ahead (d); what the samples of other layers are offered.
void block(Device& d) {
  const auto& w = d.emission_work;
  const Entries<Quanta> rest = w.rest, offered = d.transfer_work.offered;
  const Entries<std::uint8_t> blocked = w.blocked;
  const Entries<Index> receivers = w.layers, cloth = d.samples.cloth;
  const Neighbors solid(d.sample_boundary), fabric(d.sample_sample);
  const Entries<Real3> x = d.samples.position, xb = d.boundary.position, flow = w.direction;
  const Entries<Material> materials = d.materials;
  const Real h = d.support;
  const bool solids = d.boundary.count > 0 && d.model.has_direction();  // else nothing blocks
  const Layers layers = layers_of(d);
  parallel(
      "drench::emission::block", d.samples.count, KOKKOS_LAMBDA(const Index p) {
        blocked(p) = 0;
        receivers(p) = 0;
        if (rest(p) == 0) return;
        const Real cosine = materials(cloth(p)).emission_cosine;
        const Real3 here = x(p), along = flow(p);
        // Rows in folds are long: no store and no way out between the loads.
        if (solids) {
          const NeighborRow walls = solid.row(p);
          bool ahead = false;
          DRENCH_UNROLL
          for (Index k = 0; k < walls.count; ++k) ahead |= laws::in_cone(xb(walls(k)) - here, along, cosine, h);
          if (ahead) {
            blocked(p) = 1;
            return;
          }
        }
        Index others = 0;
        bool steep = false;
        const NeighborRow near = fabric.row(p);
        DRENCH_UNROLL
        for (Index k = 0; k < near.count; ++k) {
          const Index q = near(k);
          const Real3 apart = x(q) - here;
          const bool same = layers.same(p, q);
          if (!laws::in_cone(apart, along, same ? laws::ahead_cosine : cosine, h)) continue;
          if (same)
            steep = true;
          else if (materials(cloth(q)).porous)
            ++others;
        }
        if (steep) blocked(p) = 2;
        receivers(p) = others;
        if (others == 0 || rest(p) / others == 0) return;
        for (Index k = 0; k < near.count; ++k) {
          const Index q = near(k);
          if (!layers.same(p, q) && materials(cloth(q)).porous && laws::in_cone(x(q) - x(p), flow(p), cosine, h))
            Kokkos::atomic_add(&offered(q), rest(p) / others);
        }
      });
}

/// (c), second pass: with the nodes' φ known, what the layers get. rest becomes E″_p.
void give_to_layers(Device& d) {
  const auto& w = d.emission_work;
  const Entries<Quanta> rest = w.rest;
  const Entries<Index> receivers = w.layers, cloth = d.samples.cloth;
  const Neighbors list(d.sample_sample);
  const Entries<Real3> leaving_velocity = w.velocity, x = d.samples.position, flow = w.direction;
  const Transfers transfers(d);
  const Entries<Material> materials = d.materials;
  const Layers layers = layers_of(d);
  const Real h = d.support;
  parallel(
      "drench::emission::give_to_layers", d.samples.count, KOKKOS_LAMBDA(const Index p) {
        if (receivers(p) == 0) return;
        const Real cosine = materials(cloth(p)).emission_cosine;
        const Quanta offer = rest(p) / receivers(p);
        if (offer == 0) return;
        const NeighborRow near = list.row(p);
        for (Index k = 0; k < near.count; ++k) {
          const Index q = near(k);
          if (layers.same(p, q) || !materials(cloth(q)).porous || !laws::in_cone(x(q) - x(p), flow(p), cosine, h))
            continue;
          const Quanta t = limited(offer, transfers.share(q));
          transfers.give(q, offer, t, leaving_velocity(p));
          rest(p) -= t;
        }
      });
}

/// What leaves a node and what comes to it.
struct Exchange {
  Quanta out = 0;
  Arrival in;
  KOKKOS_INLINE_FUNCTION Exchange& operator+=(const Exchange& o) {
    out += o.out;
    in += o.in;
    return *this;
  }
};

/// (e): what each sample gave leaves its nodes; then what reaches them from other layers (c) arrives.
void leave(Device& d, double dt) {
  const Entries<Quanta> share = d.emission_work.share;
  const Ripening ripened(d, dt);
  const Delivery deliver(d);
  const Entries<int> any = d.emission_work.any;
  gather_rows<Exchange>(
      "drench::emission::leave", d.nodes.count, d.nodes.sample_start,
      KOKKOS_LAMBDA(const Index e) {
        return Exchange{share(3 * (deliver.item(e) / 4) + deliver.item(e) % 4), deliver(e)};
      },
      KOKKOS_LAMBDA(const Index n, const Exchange& sum) {
        if (n == 0) any(0) = any(1) = 0;
        const Quanta ripe = ripened(n);
        deliver.liquid(n) -= sum.out;
        ripened.ripe(n) = ripe > sum.out ? ripe - sum.out : 0;
        deliver(n, sum.in);
      });
}

}  // namespace

void emission(Device& d, const StepInfo& info, StepReport&) {
  if (d.samples.count == 0) return;
  prepare(d);
  if (d.emission_work.idle) {
    const EmissionCounts counts = look(d);
    if (counts.ripe == 0) {
      if (counts.empty > 0) d.compact_fluid({}, d.fluid.count - counts.empty);
      return;
    }
  }
  place_samples(d);
  shares(d, info.dt);
  give_to_liquid(d);
  count(d);
  block(d);
  limit_inflow(d);
  give_to_layers(d);
  create_particles(d);  // and removes what absorption took whole
  leave(d, info.dt);
}

}  // namespace drench::kokkos_backend
