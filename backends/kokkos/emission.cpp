// Stage emission (src/stages/emission.hpp). The letters (a) to (e) are those of its law; (d) is in
// emission_particles.cpp.

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
  make_room(w.velocity, "drench::emission::velocity", samples);
  make_room(w.blocked, "drench::emission::blocked", samples);
  make_room(w.layers, "drench::emission::layers", samples);
  make_room(w.target, "drench::emission::target", samples);
  make_room(w.pool, "drench::emission::pool", samples);
  make_room(w.candidate, "drench::emission::candidate", samples);
  const std::size_t capacity = d.fluid.position.extent(0);
  make_room(w.offered, "drench::emission::offered", capacity);
  make_room(w.gained, "drench::emission::gained", capacity);
  make_room(w.momentum, "drench::emission::momentum", 3 * capacity);
  make_room(d.transfer_work.pair, "drench::transfer::pair", d.sample_fluid.list);
}

/// e_p: where liquid leaves.
void directions(Device& d) {
  auto& w = d.emission_work;
  if (d.boundary.count == 0 || !d.model.has_direction()) {
    w.direction = d.samples.flow_direction;
    return;
  }
  make_room(w.direction, "drench::emission::direction", static_cast<std::size_t>(d.samples.count));
  const auto direction = w.direction, flow = d.samples.flow_direction;
  const auto solids = d.sample_boundary.count;
  const auto cloth = d.samples.cloth;
  const auto materials = d.materials;
  const Real3 gravity = d.gravity;
  const Real gravity_size = norm(d.gravity);
  const VirtualPressure pressure(d);
  parallel(
      "drench::emission::direction", d.samples.count, KOKKOS_LAMBDA(const Index p) {
        direction(p) = flow(p);
        if (solids(p) == 0 || !(dot(flow(p), flow(p)) > 0)) return;
        const Real epsilon = laws::flow_regularisation(gravity_size, materials(cloth(p)).virtual_pressure);
        direction(p) = laws::flow_direction(pressure(p) + gravity, epsilon);
      });
}

void ripen(Device& d, double dt) {
  const auto liquid = d.nodes.liquid, ripe = d.nodes.ripe, capacity = d.nodes.capacity_quanta;
  const auto cloth = d.nodes.cloth;
  const auto materials = d.materials;
  const double spacing = d.spacing;
  parallel(
      "drench::emission::ripen", d.nodes.count, KOKKOS_LAMBDA(const Index n) {
        const Quanta excess = liquid(n) > capacity(n) ? liquid(n) - capacity(n) : 0;
        const Quanta kept = ripe(n) < excess ? ripe(n) : excess;
        const double part = laws::ripening(materials(cloth(n)).emission_velocity, dt, spacing);
        ripe(n) = kept + static_cast<Quanta>(Kokkos::floor(part * double(excess - kept)));
      });
}

/// E_pk, E_p and v^e_p.
void shares(Device& d) {
  const auto& w = d.emission_work;
  const auto share = w.share, total = w.total, rest = w.rest, ripe = d.nodes.ripe;
  const auto leaving_velocity = w.velocity, node_velocity = d.nodes.velocity, flow = d.samples.flow_direction;
  const auto node = d.samples.node, cloth = d.samples.cloth;
  const auto weight = d.samples.weight_exact, weight_sum = d.nodes.weight_sum;
  const auto materials = d.materials;
  const bool directed = d.model.has_direction();
  parallel(
      "drench::emission::share", d.samples.count, KOKKOS_LAMBDA(const Index p) {
        const bool emits = materials(cloth(p)).porous && (!directed || dot(flow(p), flow(p)) > 0);
        Quanta sum = 0;
        double vx = 0, vy = 0, vz = 0;
        for (int k = 0; k < 3; ++k) {
          const Index n = node(3 * p + k);
          const Quanta e = emits ? laws::ripe_share(weight(3 * p + k), ripe(n), weight_sum(n)) : 0;
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
      });
}

/// (a), first half: offers to liquid in the cone, shared by room, and their sum for each particle.
void offer_to_liquid(Device& d) {
  const auto& w = d.emission_work;
  const auto offered = w.offered, gained = w.gained;
  const auto momentum = w.momentum;
  parallel(
      "drench::emission::clear_liquid", d.fluid.count, KOKKOS_LAMBDA(const Index j) {
        offered(j) = 0;
        gained(j) = 0;
        for (int c = 0; c < 3; ++c) momentum(3 * j + c) = 0;
      });
  const auto total = w.total, mass = d.fluid.mass;
  const auto count = d.sample_fluid.count;
  const auto list = d.sample_fluid.list;
  const auto pair = d.transfer_work.pair;
  const auto x = d.samples.position, xf = d.fluid.position, flow = w.direction;
  const auto cloth = d.samples.cloth;
  const auto materials = d.materials;
  const Real h = d.support;
  const Quanta full = d.model.max_quanta;
  parallel(
      "drench::emission::offer_to_liquid", d.samples.count, KOKKOS_LAMBDA(const Index p) {
        if (total(p) == 0) return;
        const Real cosine = materials(cloth(p)).emission_cosine;
        Quanta rooms = 0;
        for (Index k = 0; k < count(p); ++k) {
          const Index j = list(p, k);
          const bool takes = mass(j) > 0 && mass(j) < full && laws::in_cone(xf(j) - x(p), flow(p), cosine, h);
          pair(p, k) = takes ? full - mass(j) : 0;
          rooms += pair(p, k);
        }
        for (Index k = 0; k < count(p); ++k) {
          if (pair(p, k) == 0) continue;
          pair(p, k) = floor_ratio(total(p), pair(p, k), rooms);
          Kokkos::atomic_add(&offered(list(p, k)), pair(p, k));
        }
      });
}

/// (a), second half: what the particles accept; rest becomes E′_p.
void give_to_liquid(Device& d) {
  const auto& w = d.emission_work;
  const auto offered = w.offered, gained = w.gained, total = w.total, rest = w.rest, mass = d.fluid.mass;
  const auto momentum = w.momentum;
  const auto leaving_velocity = w.velocity, velocity = d.fluid.velocity;
  const auto count = d.sample_fluid.count;
  const auto list = d.sample_fluid.list;
  const auto pair = d.transfer_work.pair;
  const Quanta full = d.model.max_quanta;
  parallel(
      "drench::emission::give_to_liquid", d.samples.count, KOKKOS_LAMBDA(const Index p) {
        if (total(p) == 0) return;
        Quanta left = total(p);
        for (Index k = 0; k < count(p); ++k) {
          const Index j = list(p, k);
          if (pair(p, k) == 0) continue;
          const Quanta t = laws::accepted_offer(pair(p, k), offered(j), full - mass(j));
          if (t == 0) continue;
          Kokkos::atomic_add(&gained(j), t);
          add_momentum(momentum, j, t, leaving_velocity(p));
          left -= t;
        }
        rest(p) = left;
      });
  parallel(
      "drench::emission::liquid", d.fluid.count, KOKKOS_LAMBDA(const Index j) {
        if (gained(j) == 0) return;
        const double before = double(mass(j)), after = before + double(gained(j)), unit = 1 / momentum_steps;
        const Real3 v = velocity(j);
        velocity(j) = {Real((before * double(v.x) + unit * double(momentum(3 * j))) / after),
                       Real((before * double(v.y) + unit * double(momentum(3 * j + 1))) / after),
                       Real((before * double(v.z) + unit * double(momentum(3 * j + 2))) / after)};
        mass(j) += gained(j);
      });
}

/// (b): 1 for samples that see a solid in their cone, 2 for others that see their own layer ahead (d).
void block(Device& d) {
  const auto rest = d.emission_work.rest;
  const auto blocked = d.emission_work.blocked;
  const auto count = d.sample_boundary.count;
  const auto list = d.sample_boundary.list;
  const auto x = d.samples.position, xb = d.boundary.position, flow = d.emission_work.direction;
  const auto cloth = d.samples.cloth;
  const auto materials = d.materials;
  const Real h = d.support;
  const bool solids = d.boundary.count > 0 && d.model.has_direction();  // else nothing blocks
  const auto fabric_count = d.sample_sample.count;
  const auto fabric = d.sample_sample.list;
  const Layers layers = layers_of(d);
  parallel(
      "drench::emission::block", d.samples.count, KOKKOS_LAMBDA(const Index p) {
        bool sees = false;
        const Index n = solids && rest(p) > 0 ? count(p) : 0;
        for (Index k = 0; k < n && !sees; ++k)
          sees = laws::in_cone(xb(list(p, k)) - x(p), flow(p), materials(cloth(p)).emission_cosine, h);
        blocked(p) = sees ? 1 : 0;
        if (sees || rest(p) == 0) return;
        for (Index k = 0; k < fabric_count(p); ++k) {
          const Index q = fabric(p, k);
          if (layers.same(p, q) && laws::in_cone(x(q) - x(p), flow(p), laws::ahead_cosine, h)) blocked(p) = 2;
        }
      });
}

/// (c) in two passes: first what each sample is offered, then, with its nodes' φ known, what it gets. rest becomes
/// E″_p.
void to_layers(Device& d, bool give) {
  const auto& w = d.emission_work;
  const auto rest = w.rest, entering = d.transfer_work.entering;
  const auto receivers = w.layers, cloth = d.samples.cloth, count = d.sample_sample.count;
  const auto list = d.sample_sample.list;
  const auto blocked = w.blocked;
  const auto leaving_velocity = w.velocity, x = d.samples.position, flow = w.direction;
  const auto momentum = d.transfer_work.momentum;
  const auto share = d.transfer_work.inflow_share;
  const auto materials = d.materials;
  const Layers layers = layers_of(d);
  const Real h = d.support;
  parallel(
      give ? "drench::emission::give_to_layers" : "drench::emission::offer_to_layers", d.samples.count,
      KOKKOS_LAMBDA(const Index p) {
        if (rest(p) == 0 || blocked(p) == 1 || (give && receivers(p) == 0)) return;
        const Real cosine = materials(cloth(p)).emission_cosine;
        const auto receives = [&](const Index q) {
          return materials(cloth(q)).porous && !layers.same(p, q) && laws::in_cone(x(q) - x(p), flow(p), cosine, h);
        };
        if (!give) {
          Index n = 0;
          for (Index k = 0; k < count(p); ++k) n += receives(list(p, k)) ? 1 : 0;
          receivers(p) = n;
          if (n == 0) return;
        }
        const Quanta offer = rest(p) / receivers(p);
        if (offer == 0) return;
        for (Index k = 0; k < count(p); ++k) {
          const Index q = list(p, k);
          if (!receives(q)) continue;
          const Quanta t = give ? limited(offer, share(q)) : offer;
          Kokkos::atomic_add(&entering(q), t);
          if (!give) continue;
          add_momentum(momentum, q, t, leaving_velocity(p));
          rest(p) -= t;
        }
      });
}

/// (e): what each sample gave, in all, leaves its nodes; the rest was never taken from them.
void leave(Device& d, bool any_created) {
  const auto& w = d.emission_work;
  const auto share = w.share, total = w.total, rest = w.rest, pools = w.pool;
  const auto target = w.target, candidate = w.candidate;
  const auto created = w.created;
  const Quanta full = d.model.max_quanta;
  parallel(
      "drench::emission::given", d.samples.count, KOKKOS_LAMBDA(const Index p) {
        if (total(p) == 0) return;
        Quanta given = total(p) - rest(p);
        const Index q = any_created ? target(p) : -1;
        if (q >= 0 && target(q) == q && pools(q) > 0 && created(candidate(q)))
          given += pooled_part(rest(p), pools(q), full);
        Quanta left = given;
        Quanta part[3];
        for (int k = 0; k < 3; ++k) {
          part[k] = floor_ratio(given, share(3 * p + k), total(p));
          left -= part[k];
        }
        for (int k = 0; k < 3; ++k) {
          const Quanta room = share(3 * p + k) - part[k];
          const Quanta more = left < room ? left : room;
          share(3 * p + k) = part[k] + more;
          left -= more;
        }
      });
  const auto start = d.nodes.sample_start, item = d.nodes.sample_item;
  const auto liquid = d.nodes.liquid, ripe = d.nodes.ripe;
  parallel(
      "drench::emission::leave", d.nodes.count, KOKKOS_LAMBDA(const Index n) {
        Quanta out = 0;
        for (Index e = start(n); e < start(n + 1); ++e) out += share(3 * (item(e) / 4) + item(e) % 4);
        liquid(n) -= out;
        ripe(n) = ripe(n) > out ? ripe(n) - out : 0;
      });
}

}  // namespace

void emission(Device& d, const StepInfo& info, StepReport&) {
  if (d.samples.count == 0) return;
  prepare(d);
  refresh_samples(d);
  directions(d);
  ripen(d, info.dt);
  shares(d);
  offer_to_liquid(d);
  give_to_liquid(d);
  block(d);
  clear_transfers(d, true);
  to_layers(d, false);
  limit_inflow(d);
  clear_transfers(d, true);
  to_layers(d, true);
  leave(d, create_particles(d) > 0);
  deliver(d);
  d.compact_fluid({});  // what absorption took whole
}

}  // namespace drench::kokkos_backend
