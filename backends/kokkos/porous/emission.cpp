// Stage emission (src/stages/emission.hpp). The letters (a) to (e) are those of its law; (d) is in
// emission_particles.cpp, (e) in emission_nodes.cpp. The host waits once: for the number of new particles, or, as long
// as nothing is buffered, for that news.

#include "core/filled_rows.hpp"
#include "porous/emission_law.hpp"
#include "porous/emission_particles.hpp"
#include "porous/faces.hpp"
#include "porous/stages.hpp"
#include "porous/transfer.hpp"
#include "porous/virtual_pressure.hpp"

namespace drench::kokkos_backend {
namespace {

void prepare(const Constants& constants, const Bodies& bodies, Cloth& cloth, TransferWork& transfers,
             EmissionWork& work) {
  const auto samples = static_cast<std::size_t>(cloth.samples.count);
  make_room(work.share, "drench::emission::share", 3 * samples);
  make_room(work.total, "drench::emission::total", samples);
  make_room(work.rest, "drench::emission::rest", samples);
  make_room(work.room, "drench::emission::room", samples);
  make_room(work.velocity, "drench::emission::velocity", samples);
  make_room(work.blocked, "drench::emission::blocked", samples);
  make_room(work.layers, "drench::emission::layers", samples);
  if (bodies.boundary.count > 0 && constants.model.has_direction())
    make_room(work.direction, "drench::emission::direction", samples);
  allocate_zeros(work.any, "drench::emission::any", 2);
  make_room_for_one(work.counts, "drench::emission::counts");
  make_room_for_one(work.new_particles, "drench::emission::new_particles");
  prepare_transfers(constants, cloth, transfers);
}

}  // namespace

MemoryEstimate emission_bytes(const Sizing& s) {
  if (!s.size.emission) return {};
  const double r = s.real, direction = s.size.direction && s.size.boundary > 0 ? 3 * r : 0;
  MemoryEstimate sum = candidate_bytes(s);
  // share, total, rest, room; velocity, blocked, layers
  sum.cloth += s.size.samples * (6 * quanta_bytes + 3 * r + 1 + index_bytes + direction);
  if (s.size.solute) sum.cloth += s.size.samples * 5 * quanta_bytes;  // solute_share, solute_total, solute_rest
  return sum;
}

namespace {

/// Whether anything may be buffered, and how many particles are empty.
EmissionCounts look(const Constants& constants, const Fluid& fluid, Cloth& cloth, const EmissionWork& work) {
  const Maturing maturing(constants, cloth, 0);
  const Entries<const Quanta> mass = fluid.particles.mass;
  const Index nodes = cloth.nodes.count, particles = fluid.particles.count;
  const auto counts = work.counts;
  Kokkos::parallel_reduce(
      "drench::emission::buffered", range(nodes > particles ? nodes : particles),
      KOKKOS_LAMBDA(const Index k, EmissionCounts& sum) {
        if (k < nodes && maturing.any(k)) ++sum.buffered;
        if (k < particles && mass(k) == 0) ++sum.empty;
      },
      counts);
  exec().fence("drench::emission::buffered");
  return counts();
}

/// e_p, where liquid leaves.
struct Direction {
  Entries<const Real3> flow;
  Driven driven;
  Real3 gravity;
  Real gravity_size;

  explicit Direction(const Constants& constants, const Cloth& cloth)
      : flow(cloth.samples.flow_direction),
        driven(cloth),
        gravity(constants.gravity),
        gravity_size(norm(constants.gravity)) {}
  KOKKOS_INLINE_FUNCTION Real3 operator()(Index p, const VirtualPressure& pressure) const {
    if (pressure.count(p) == 0 || driven(p) || !(dot(flow(p), flow(p)) > 0)) return flow(p);
    const Real epsilon = laws::flow_regularisation(gravity_size, pressure.materials(p).virtual_pressure);
    return laws::flow_direction(pressure(p) + gravity, epsilon);
  }
};

/// e_p, E_pk, E_p and v^e_p; nothing is on its way.
void shares(const Constants& constants, const NeighborLists& lists, const Bodies& bodies, Cloth& cloth,
            TransferWork& transfers, EmissionWork& work, double dt) {
  const Entries<Quanta> share = work.share, total = work.total, rest = work.rest, room = work.room;
  const Entries<Real3> leaving_velocity = work.velocity, direction = work.direction;
  const Entries<const Real3> node_velocity = cloth.nodes.velocity, flow = cloth.samples.flow_direction;
  const Entries<const double> weight_sum = cloth.nodes.weight_sum;
  const Entries<int> any = work.any;
  const Maturing matured(constants, cloth, dt);
  const Transfers exchange(cloth, transfers);
  const bool directed = constants.model.has_direction(), solids = directed && bodies.boundary.count > 0;
  const Direction outward(constants, cloth);
  const VirtualPressure pressure(constants, lists, bodies, cloth);
  parallel(
      "drench::emission::share", cloth.samples.count, KOKKOS_LAMBDA(const Index p) {
        exchange.clear(p);
        room(p) = 0;
        const bool emits = pressure.materials(p).porous && (!directed || dot(flow(p), flow(p)) > 0);
        Quanta sum = 0;
        double vx = 0, vy = 0, vz = 0;
        bool ready = false;
        for (int k = 0; k < 3; ++k) {
          const Index n = exchange.node(3 * p + k);
          ready = ready || matured.any(n);
          const Quanta e = emits ? laws::buffered_share(exchange.weight(3 * p + k), matured(n), weight_sum(n)) : 0;
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
        if (ready && any(0) == 0) Kokkos::atomic_store(&any(0), 1);
        if (sum > 0 && solids) direction(p) = outward(p, pressure);
      });
}

/// What (a) asks about a liquid particle and a sample near it.
struct Reach {
  Neighbors list;
  Entries<const Real3> sample, flow;
  Entries<Real3> liquid;
  Materials materials;
  Entries<Quanta> mass, total;
  Entries<int> any;
  Real support;
  Quanta full;

  explicit Reach(const Constants& constants, Fluid& fluid, const NeighborLists& lists, const Cloth& fabric,
                 EmissionWork& work)
      : list(lists.fluid_sample),
        sample(fabric.samples.position),
        flow(leaving_directions(fabric, work)),
        liquid(fluid.particles.position),
        materials(sample_materials(fabric)),
        mass(fluid.particles.mass),
        total(work.total),
        any(work.any),
        support(constants.support),
        full(constants.model.max_quanta) {}
  KOKKOS_INLINE_FUNCTION bool takes(Index j) const { return any(0) != 0 && mass(j) > 0 && mass(j) < full; }
  /// Does sample p offer to particle j?
  KOKKOS_INLINE_FUNCTION bool offers(Index p, Index j) const {
    return total(p) > 0 && laws::in_cone(liquid(j) - sample(p), flow(p), materials(p).emission_cosine, support);
  }
};

/// Which of a lane's places in a particle's list offer to it: those beyond 64 are asked again.
struct Offering {
  std::uint64_t first = 0;
  KOKKOS_INLINE_FUNCTION void add(Index k) {
    if (k < 64) first |= std::uint64_t{1} << k;
  }
  /// May place k be one?
  KOKKOS_INLINE_FUNCTION bool at(Index k) const { return k >= 64 || (first >> k & 1) != 0; }
};

/// What a particle gets; in whole numbers, so that their sum does not depend on its order.
struct Gain {
  Quanta mass = 0, solute = 0;
  std::int64_t px = 0, py = 0, pz = 0;
  KOKKOS_INLINE_FUNCTION void add(Quanta t, const Real3& v) {
    mass += t;
    px += fixed_momentum(t, v.x);
    py += fixed_momentum(t, v.y);
    pz += fixed_momentum(t, v.z);
  }
  KOKKOS_INLINE_FUNCTION Gain& operator+=(const Gain& o) {
    mass += o.mass;
    solute += o.solute;
    px += o.px;
    py += o.py;
    pz += o.pz;
    return *this;
  }
};

/// (a): the room that each sample sees, then what each particle accepts; rest becomes E′_p.
void give_to_liquid(const Constants& constants, Fluid& fluid, const NeighborLists& lists, const Cloth& cloth,
                    TransferWork& transfers, EmissionWork& work) {
  const Reach reach(constants, fluid, lists, cloth, work);
  const Faces faces(cloth, transfers);
  const Entries<Quanta> room = work.room, rest = work.rest;
  const Entries<const Real3> leaving_velocity = work.velocity;
  const Entries<Real3> velocity = fluid.particles.velocity;
  const Entries<Quanta> dissolved = fluid.particles.solute;
  const SampleSolute solute(work);
  parallel_filled_rows(
      "drench::emission::room", lists.near_sheet, KOKKOS_LAMBDA(const Index j, const Index lane) {
        const NeighborRow near = reach.list.row(j);
        if (near.count == 0 || !reach.takes(j)) return;
        const Quanta own_room = reach.full - reach.mass(j);
        for (Index k = lane; k < near.count; k += row_lanes) {
          const Index p = near(k);
          if (reach.offers(p, j)) Kokkos::atomic_add(&room(p), own_room);
        }
      });
  fluid.exchange.add_up(work.room, cloth.samples.count);
  parallel_filled_rows(
      "drench::emission::give_to_liquid", lists.near_sheet, KOKKOS_LAMBDA(const Index j, const Index lane) {
        const NeighborRow near = reach.list.row(j);
        if (near.count == 0 || !reach.takes(j)) return;
        const Quanta mass = reach.mass(j), own_room = reach.full - mass;
        Offering offering;
        Quanta offered = 0;
        for (Index k = lane; k < near.count; k += row_lanes) {
          const Index p = near(k);
          if (!reach.offers(p, j)) continue;
          offering.add(k / row_lanes);
          offered += floor_ratio(reach.total(p), own_room, room(p));
        }
        offered = sum_of_lanes(offered);
        if (offered == 0) return;
        Gain gain;
        for (Index k = lane; k < near.count; k += row_lanes) {
          if (!offering.at(k / row_lanes)) continue;
          const Index p = near(k);
          if (k / row_lanes >= 64 && !reach.offers(p, j)) continue;
          const Quanta t = laws::accepted_offer(floor_ratio(reach.total(p), own_room, room(p)), offered, own_room);
          if (t == 0) continue;
          gain.add(t, leaving_velocity(p));
          Kokkos::atomic_add(&rest(p), -t);
          faces.count(p, reach.liquid(j) - reach.sample(p), t);
          if (solute.exists()) gain.solute += solute.take(p, t);
        }
        gain = sum_of_lanes(gain);
        if (gain.mass == 0 || lane > 0) return;
        const double before = double(mass), after = before + double(gain.mass), unit = 1 / momentum_steps;
        const Real3 v = velocity(j);
        velocity(j) = {Real((before * double(v.x) + unit * double(gain.px)) / after),
                       Real((before * double(v.y) + unit * double(gain.py)) / after),
                       Real((before * double(v.z) + unit * double(gain.pz)) / after)};
        reach.mass(j) = mass + gain.mass;
        if (solute.exists()) dissolved(j) += gain.solute;
      });
}

/// What all ranks' liquid has left of a total that each rank began with.
void add_up_rest(const Exchange& exchange, const Cloth& cloth, Field<Quanta>& left, const Field<Quanta>& of_total) {
  if (exchange.alone()) return;
  exchange.add_up(left, cloth.samples.count);
  const Quanta others = exchange.ranks()->size() - 1;
  const Entries<Quanta> rest = left;
  const Entries<const Quanta> total = of_total;
  parallel(
      "drench::emission::rest", cloth.samples.count, KOKKOS_LAMBDA(const Index p) { rest(p) -= others * total(p); });
}

/// For the host: how many particles are empty, and whether anything is buffered. By itself: within a reduction of
/// Kokkos loops over neighbours run at half the speed.
void count(const Fluid& fluid, const EmissionWork& work) {
  const Entries<const Quanta> mass = fluid.particles.mass;
  const Entries<const int> any = work.any;
  const Index particles = fluid.particles.count;
  Kokkos::parallel_reduce(
      "drench::emission::count", range(particles > 0 ? particles : 1),
      KOKKOS_LAMBDA(const Index j, EmissionCounts& counts) {
        if (j == 0) counts.buffered = any(0);
        if (j < particles && mass(j) == 0) ++counts.empty;
      },
      work.counts);
}

/// (b) and the first pass of (c). blocked: 1 for samples that see a solid in their cone, 2 for others that see their
/// own layer ahead or are shut in by another one (d); what the samples of other layers are offered.
void block(const Constants& constants, const NeighborLists& lists, const Bodies& bodies, const Cloth& cloth,
           TransferWork& transfers, EmissionWork& work) {
  const Entries<const Quanta> rest = work.rest;
  const Entries<Quanta> offered = transfers.offered;
  const Entries<std::uint8_t> blocked = work.blocked;
  const Entries<Index> receivers = work.layers;
  const Neighbors solid(lists.sample_boundary), fabric(lists.sample_sample);
  const Entries<const Real3> x = cloth.samples.position, xb = bodies.boundary.position,
                             flow = leaving_directions(cloth, work);
  const Materials materials = sample_materials(cloth);
  const Real h = constants.support, spacing = constants.spacing;
  const bool directed = constants.model.has_direction(),
             solids = bodies.boundary.count > 0 && directed;  // else nothing blocks
  const Layers layers = layers_of(constants, cloth);
  const Driven driven(cloth);
  parallel(
      "drench::emission::block", cloth.samples.count, KOKKOS_LAMBDA(const Index p) {
        blocked(p) = 0;
        receivers(p) = 0;
        if (rest(p) == 0) return;
        const Real cosine = materials(p).emission_cosine;
        const Real3 here = x(p), along = flow(p);
        // Rows in folds are long: no store and no way out between the loads.
        if (solids) {
          bool ahead = false;
          const bool shut = driven(p);
          solid.for_each(p, [&](Index j) {
            const Real3 apart = xb(j) - here;
            ahead |= shut ? laws::shuts_in(apart, along, spacing) : laws::in_cone(apart, along, cosine, h);
          });
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
          steep |= !same && directed && laws::shuts_in(apart, along, spacing);
          if (!laws::in_cone(apart, along, same ? laws::ahead_cosine : cosine, h)) continue;
          if (same)
            steep = true;
          else if (materials(q).porous)
            ++others;
        }
        if (steep) blocked(p) = 2;
        receivers(p) = others;
        if (others == 0 || rest(p) / others == 0) return;
        for (Index k = 0; k < near.count; ++k) {
          const Index q = near(k);
          if (!layers.same(p, q) && materials(q).porous && laws::in_cone(x(q) - x(p), flow(p), cosine, h))
            Kokkos::atomic_add(&offered(q), rest(p) / others);
        }
      });
}

/// (c), second pass: with the nodes' φ known, what the layers get. rest becomes E″_p.
void give_to_layers(const Constants& constants, const NeighborLists& lists, const Cloth& cloth, TransferWork& transfers,
                    EmissionWork& work) {
  const Entries<Quanta> rest = work.rest;
  const Entries<const Index> receivers = work.layers;
  const Neighbors list(lists.sample_sample);
  const Entries<const Real3> leaving_velocity = work.velocity, x = cloth.samples.position,
                             flow = leaving_directions(cloth, work);
  const Transfers exchange(cloth, transfers);
  const Materials materials = sample_materials(cloth);
  const Layers layers = layers_of(constants, cloth);
  const SampleSolute solute(work);
  const Real h = constants.support;
  parallel_rows(
      "drench::emission::give_to_layers", cloth.samples.count, KOKKOS_LAMBDA(const Index p, const Index lane) {
        if (receivers(p) == 0) return;
        const Real cosine = materials(p).emission_cosine;
        const Quanta offer = rest(p) / receivers(p);
        if (offer == 0) return;
        const NeighborRow near = list.row(p);
        Quanta given = 0;
        for (Index k = lane; k < near.count; k += row_lanes) {
          const Index q = near(k);
          if (layers.same(p, q) || !materials(q).porous || !laws::in_cone(x(q) - x(p), flow(p), cosine, h)) continue;
          const Quanta t = limited(offer, exchange.share(q));
          exchange.give(q, offer, t, leaving_velocity(p));
          if (solute.exists() && t > 0) Kokkos::atomic_add(&exchange.solute(q), solute.take(p, t));
          given += t;
        }
        given = sum_of_lanes(given);
        if (lane == 0) rest(p) -= given;
      });
}

}  // namespace

void emission(const Constants& constants, Fluid& fluid, const NeighborLists& lists, const Bodies& bodies, Cloth& cloth,
              TransferWork& transfers, EmissionWork& work, const StepInfo& info) {
  cloth.soaked.advance();
  if (cloth.samples.count == 0) return;
  prepare(constants, bodies, cloth, transfers, work);
  if (work.idle) {
    const EmissionCounts counts = look(constants, fluid, cloth, work);
    if (counts.buffered == 0) {
      if (counts.empty > 0) fluid.particles.compact({}, fluid.particles.count - counts.empty);
      return;
    }
  }
  place_samples(cloth);
  shares(constants, lists, bodies, cloth, transfers, work, info.dt);
  const bool dyed = constants.model.has_solute();
  if (dyed) share_solute(cloth, work);
  clear_faces(cloth, transfers);
  give_to_liquid(constants, fluid, lists, cloth, transfers, work);
  add_up_rest(fluid.exchange, cloth, work.rest, work.total);
  if (dyed) add_up_rest(fluid.exchange, cloth, work.solute_rest, work.solute_total);
  if (transfers.front.exists()) fluid.exchange.add_up(transfers.front, cloth.samples.count);
  count_given(cloth, transfers, work.total, work.rest);
  count(fluid, work);
  block(constants, lists, bodies, cloth, transfers, work);
  limit_inflow(cloth, transfers);
  give_to_layers(constants, lists, cloth, transfers, work);
  create_particles(constants, fluid, lists, cloth, work);  // and removes what absorption took whole
  if (dyed) leave_solute(cloth, transfers, work);
  leave(constants, cloth, transfers, work, info.dt);
}

}  // namespace drench::kokkos_backend
