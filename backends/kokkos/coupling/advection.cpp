// Stage advection (law: src/stages/advection.hpp).

#include <algorithm>
#include <cmath>
#include <cstring>
#include <vector>

#include "bodies/contact.hpp"
#include "bodies/pushed_bodies.hpp"
#include "cloth/pins.hpp"
#include "core/fixed_point.hpp"
#include "core/host_copy.hpp"
#include "core/reduce.hpp"
#include "coupling/cloth_motion.hpp"
#include "coupling/sweep.hpp"
#include "state/domain_border.hpp"

namespace drench::kokkos_backend {
namespace {

/// Adds w · m · Δv (m in quanta) to a node's momentum.
KOKKOS_INLINE_FUNCTION void add_momentum(const Entries<std::int64_t>& momentum, Index node, double quanta,
                                         const Double3& dv) {
  add_fixed(momentum, node, times(momentum_steps * quanta, dv));
}

Array<Drain> drains_of(const std::vector<DrainScene>& scenes) {
  std::vector<Drain> drains;
  for (const DrainScene& scene : scenes) {
    const auto point = [](const Vec3& x) { return Double3{x[0], x[1], x[2]}; };
    Drain drain{scene.shape, point(scene.box.min), point(scene.box.max), scene.radius, scene.start, scene.end};
    if (scene.shape == DrainScene::Shape::sphere) drain.a = point(scene.center);
    if (scene.shape == DrainScene::Shape::plane) {
      drain.a = point(scene.point);
      drain.b = point(scene.normal);
    }
    drains.push_back(drain);
  }
  return to_device<Drain>("drench::advection::drains", drains);
}

void allocate_work(const Constants& constants, Fluid& fluid, const Cloth& cloth, AdvectionWork& work) {
  if (work.counts.data() == nullptr) {
    make_room_for_one(work.counts, "drench::advection::counts");
    work.motion = Kokkos::View<ClothMotion, MemSpace>("drench::advection::motion");
    work.near_count = Kokkos::View<Index, MemSpace>("drench::advection::near_count");
    work.far_count = Kokkos::View<Index, MemSpace>("drench::advection::far_count");
  }
  const auto nodes = static_cast<std::size_t>(cloth.nodes.count);
  allocate_zeros(work.start, "drench::advection::start", nodes);
  allocate_zeros(work.momentum, "drench::advection::momentum", 3 * nodes);
  allocate_zeros(work.hits, "drench::advection::hits", nodes);
  allocate_zeros(work.box, "drench::advection::box", static_cast<std::size_t>(cloth.mesh.triangles));
  const std::size_t capacity = fluid.particles.capacity();
  if (capacity == 0) return;
  make_room(work.gone, "drench::advection::gone", capacity);
  make_room(work.end, "drench::advection::end", capacity);
  if (constants.model.has_drains() && !work.drains.exists())
    work.drains = drains_of(constants.model.scene.fluid.drains);
  if (cloth.samples.count == 0 || constants.model.has_baked_liquid()) return;
  order_triangles(constants, work);
  make_room(work.hit_triangle, "drench::advection::hit_triangle", capacity);
  make_room(work.hit_weight, "drench::advection::hit_weight", capacity);
  make_room(work.hit_normal, "drench::advection::hit_normal", capacity);
  if (!on_host) make_room(work.near, "drench::advection::near", capacity);
  if (!on_host) make_room(work.far, "drench::advection::far", capacity);
  if (fluid.tunnelled.data() == nullptr)
    fluid.tunnelled = Kokkos::View<Tunnelled, MemSpace>("drench::advection::tunnelled");
}

}  // namespace

MemoryEstimate advection_bytes(const Sizing& s) {
  const double r = s.real;
  double particle = 3 * r + 1;                                   // end, gone
  if (s.size.samples > 0) particle += 6 * r + index_bytes;       // hit_weight, hit_normal, hit_triangle
  if (s.size.samples > 0 && s.gpu) particle += 2 * index_bytes;  // near, far
  MemoryEstimate sum;
  sum.particles = particle_room(s) * particle;
  if (s.size.moving_cloth || s.size.liquid)  // start, momentum, hits; box
    sum.cloth = s.size.nodes * (3 * r + 3 * sizeof(std::int64_t) + index_bytes) + s.size.triangles * 6 * r;
  if (s.size.self_collision && s.size.samples > 0 && s.size.fluid > 0)  // ordered, and a cluster_box for 32
    sum.cloth += s.size.triangles * (index_bytes + 6 * r / 32);
  return sum;
}

namespace {

/// Law 1: limits the speed of fresh particles relative to the cloth; the cloth gets the momentum.
void limit_fresh(const Constants& constants, Fluid& fluid, const NeighborLists& lists, const Cloth& cloth,
                 AdvectionWork& work) {
  const Entries<const Real3> position = fluid.particles.position, sample_position = cloth.samples.position,
                             node_velocity = cloth.nodes.velocity;
  const Entries<Real3> velocity = fluid.particles.velocity;
  const Entries<const Quanta> mass = fluid.particles.mass;
  const Entries<const Real> age = fluid.particles.age, weight = cloth.samples.weight;
  const Entries<const std::uint8_t> origin = fluid.particles.origin;
  const Neighbors list(lists.fluid_sample);
  const Entries<const Index> sample_node = cloth.samples.node;
  const Entries<std::int64_t> momentum = work.momentum;
  const Real ramp = cloth.emission_ramp, base_speed = constants.spacing / cloth.emission_ramp,
             fall = 2 * norm(constants.gravity);
  parallel(
      "drench::advection::fresh", fluid.particles.count, KOKKOS_LAMBDA(const Index i) {
        if (origin(i) != static_cast<std::uint8_t>(Origin::cloth) || !(age(i) < ramp)) return;
        Index nearest = -1;
        Real best = 0;
        list.for_each(i, [&](Index p) {
          const Real3 apart = position(i) - sample_position(p);
          const Real square = dot(apart, apart);
          if (nearest >= 0 && !(square < best)) return;
          nearest = p;
          best = square;
        });
        if (nearest < 0) return;
        Real3 cloth_velocity;
        for (Index k = 0; k < 3; ++k)
          cloth_velocity += weight(3 * nearest + k) * node_velocity(sample_node(3 * nearest + k));
        const Real3 relative = velocity(i) - cloth_velocity;
        const Real speed = norm(relative), limit = base_speed + fall * age(i);
        if (!(speed > limit)) return;
        const Real3 removed_velocity = (1 - limit / speed) * relative;
        velocity(i) -= removed_velocity;
        for (Index k = 0; k < 3; ++k)
          add_momentum(momentum, sample_node(3 * nearest + k),
                       static_cast<double>(weight(3 * nearest + k)) * static_cast<double>(mass(i)),
                       widen(removed_velocity));
      });
}

/// Law 3, impulses: inelastic along the normal; each of the c_k particles at a node counts on a c_k-th of its mass.
void exchange_impulses(const Constants& constants, Fluid& fluid, const Cloth& cloth, AdvectionWork& work) {
  const Entries<Real3> velocity = fluid.particles.velocity;
  const Entries<const Real3> node_velocity = cloth.nodes.velocity, hit_weight = work.hit_weight,
                             hit_normal = work.hit_normal;
  const Entries<const Quanta> mass = fluid.particles.mass;
  const Entries<const Real> inverse_mass = cloth.nodes.inverse_mass;
  const Entries<const Index> hit_triangle = work.hit_triangle, hits = work.hits, triangle = cloth.mesh.triangle;
  const Entries<std::int64_t> momentum = work.momentum;
  const double quantum = constants.quantum;
  parallel(
      "drench::advection::impulse", fluid.particles.count, KOKKOS_LAMBDA(const Index i) {
        const Index t = hit_triangle(i);
        if (t < 0 || mass(i) <= 0) return;
        const Double3 n = widen(hit_normal(i));
        const Double3 b3 = widen(hit_weight(i));
        const double b[3] = {b3.x, b3.y, b3.z};
        Double3 relative = widen(velocity(i));
        double inverse = 1 / (quantum * static_cast<double>(mass(i)));
        for (Index k = 0; k < 3; ++k) {
          const Index node = triangle(3 * t + k);
          relative = minus(relative, times(b[k], widen(node_velocity(node))));
          inverse += b[k] * b[k] * static_cast<double>(hits(node)) * static_cast<double>(inverse_mass(node));
        }
        const double inward = inner(relative, n);
        if (!(inward < 0)) return;
        const double impulse = -inward / inverse;                                    // kg m/s
        const double particle = impulse / (quantum * static_cast<double>(mass(i)));  // m/s
        velocity(i) = narrow(add(widen(velocity(i)), times(particle, n)));
        for (Index k = 0; k < 3; ++k)
          add_momentum(momentum, triangle(3 * t + k), static_cast<double>(mass(i)), times(-b[k] * particle, n));
      });
}

/// v_n += u_n p_n, and what pins hold against; the sums are zero again for the next step.
void apply_momentum(const Constants& constants, Cloth& cloth, AdvectionWork& work, double dt) {
  const Entries<Real3> velocity = cloth.nodes.velocity, pin_force = cloth.nodes.pin_force;
  const Entries<const std::uint8_t> fixed = cloth.nodes.fixed;
  const Entries<const Real> inverse_mass = cloth.nodes.inverse_mass;
  const Entries<std::int64_t> momentum = work.momentum;
  const Entries<Index> hits = work.hits;
  const auto near_count = work.near_count, far_count = work.far_count;
  const double unit = constants.quantum / momentum_steps;
  parallel(
      "drench::advection::momentum", cloth.nodes.count, KOKKOS_LAMBDA(const Index n) {
        const Double3 p{static_cast<double>(momentum(3 * n)), static_cast<double>(momentum(3 * n + 1)),
                        static_cast<double>(momentum(3 * n + 2))};
        velocity(n) = narrow(add(widen(velocity(n)), times(unit * static_cast<double>(inverse_mass(n)), p)));
        if (fixed(n)) pin_force(n) = narrow(minus(widen(pin_force(n)), times(unit / dt, p)));
        for (Index a = 0; a < 3; ++a) momentum(3 * n + a) = 0;
        hits(n) = 0;
        if (n == 0) near_count() = far_count() = 0;
      });
}

/// Laws 4 and 5: bodies' failsafe, new position and age, and who left the domain or is in a drain at the end, `time`.
/// `swept`: x1 is known. `pushes`: on bodies that a program moves.
void finish_fluid(const Constants& constants, Fluid& fluid, const NeighborLists& lists, const Bodies& bodies,
                  const PushesOnBodies& pushes, AdvectionWork& work, Real dt, double time, bool swept) {
  const Entries<Real3> position = fluid.particles.position, velocity = fluid.particles.velocity;
  const Entries<const Real3> end = work.end, shift = fluid.separation;
  const bool baked = constants.model.has_baked_liquid();
  const Entries<Real> age = fluid.particles.age;
  const Entries<const Quanta> mass = fluid.particles.mass;
  const Entries<std::uint8_t> gone = work.gone;
  const Entries<const Index> hit_triangle = work.hit_triangle, near_cloth = lists.fluid_sample.count;
  const bool listed = swept && lists.fluid_sample.rows == fluid.particles.local();
  const Slice<const Solid> solids = baked ? Slice<const Solid>{} : Slice<const Solid>(bodies.solids);
  const Slice<const Drain> drains = std::as_const(work.drains);
  const double quantum = constants.quantum;
  const Real spacing = constants.spacing;
  const drench::Box border = domain_border(constants.model);
  const Double3 lo{border.min[0], border.min[1], border.min[2]}, hi{border.max[0], border.max[1], border.max[2]};
  Kokkos::parallel_reduce(
      "drench::advection::finish", range(fluid.particles.count),
      KOKKOS_LAMBDA(const Index i, AdvectionCounts& counts) {
        Real3 v = velocity(i), x = swept ? end(i) : position(i) + dt * v;
        if (!swept && !baked) x += shift(i);
        if (swept && hit_triangle(i) >= 0) ++counts.collisions;
        bool put_back = false;
        for (std::int64_t b = 0; b < solids.count; ++b) {
          SolidDistance body = solid_distance(solids(b), x, Real3{});
          bool entered = false;
          if (solids(b).has_far_side() && body.phi < far_away) {
            const Real3 start = position(i) + dt * surface_velocity(solids(b), position(i), Real3{}), way = x - start;
            if (body.phi < norm(way) && (body.phi >= 0 || body.phi < -grazing * spacing || dot(body.normal, way) > 0)) {
              entered = stop_at_entry(solids(b), start, spacing, x);
              if (entered) body = solid_distance(solids(b), x, Real3{});
            }
          }
          if (!(body.phi < 0) && !entered) continue;
          const Real3 before = v;
          v = without_inward(v, body.normal, surface_velocity(solids(b), x, Real3{}));
          const auto body_pushed = static_cast<std::size_t>(solids(b).body);
          if (pushes.takes_commanded(body_pushed))
            pushes.add(body_pushed, widen(x - solids(b).center),
                       times(quantum * static_cast<double>(mass(i)), widen(before - v)));
          if (body.phi < 0) x += to_distance(solids(b), x, Real3{}, body, 0);
          put_back = true;
        }
        if (put_back) {
          ++counts.clamped;
          if (listed && near_cloth(i) > 0) ++counts.put_back_near;
          velocity(i) = v;
        }
        position(i) = x;
        age(i) += dt;
        const Double3 at = widen(x);
        const bool outside = at.x < lo.x || at.y < lo.y || at.z < lo.z || at.x > hi.x || at.y > hi.y || at.z > hi.z;
        bool drained = false;
        for (std::int64_t k = 0; k < drains.count; ++k) drained = drained || drains(k).takes(at, time);
        gone(i) = outside ? 1 : drained ? 2 : 0;
        if (outside || drained || !(mass(i) > 0)) ++counts.gone;
        if (drained && !outside) counts.drained += static_cast<std::int64_t>(mass(i));
        if (!outside) return;
        ++counts.removed;
        const double square = double(dot(v, v));
        if (square > counts.square) counts.square = square;
        counts.drained += static_cast<std::int64_t>(mass(i));
      },
      work.counts);
}

/// The lowest ids of each rank, `most` of them.
std::vector<std::int64_t> ids_of_all(const Communicator* ranks, std::vector<std::int64_t> ids, std::size_t most) {
  if (!ranks) return ids;
  std::sort(ids.begin(), ids.end());
  ids.resize(most, INT64_MAX);
  const std::vector<std::byte> bytes = ranks->all_gather(ids.data(), ids.size() * sizeof(std::int64_t));
  std::vector<std::int64_t> all(bytes.size() / sizeof(std::int64_t));
  std::memcpy(all.data(), bytes.data(), bytes.size());
  std::erase(all, INT64_MAX);
  return all;
}

/// Among the particles leaving the domain, those faster than `limit`, m/s. Asked for only in steps that are suspicious.
SomeParticles escaped(const Fluid& fluid, const AdvectionWork& work, double limit) {
  const auto gone = to_host<std::uint8_t>(work.gone, fluid.particles.count);
  const auto id = to_host<std::int64_t>(fluid.particles.id, fluid.particles.count);
  const auto velocity = to_host<Vec3>(fluid.particles.velocity, fluid.particles.count);
  std::vector<std::int64_t> ids;
  for (std::size_t i = 0; i < gone.size(); ++i)
    if (gone[i] == 1 && std::hypot(velocity[i][0], velocity[i][1], velocity[i][2]) > limit) ids.push_back(id[i]);
  SomeParticles some{static_cast<std::int64_t>(ids.size()), {}};
  ids = ids_of_all(fluid.exchange.ranks(), ids, some.lowest.size());
  std::partial_sort_copy(ids.begin(), ids.end(), some.lowest.begin(), some.lowest.end());
  OverRanks(fluid.exchange.ranks()).sum(some.count).reduce();
  return some;
}

/// Those that have left the domain.
void count_removed(const Fluid& fluid, const AdvectionWork& work, const StepInfo& info, const AdvectionCounts& counts,
                   StepReport& report) {
  report.escaped_speed = std::sqrt(counts.square);
  const bool fast = report.escaped_speed > info.fluid_speed_limit;
  if (fast || (counts.removed >= 100 && 4 * counts.removed > fluid.particles.next_id))
    report.escaped = escaped(fluid, work, fast ? info.fluid_speed_limit : -1);
}

/// Quanta of solute that leave the domain, and of particles whose liquid has gone from around it.
struct GoneSolute {
  Quanta drained = 0, deposited = 0;
  KOKKOS_INLINE_FUNCTION GoneSolute& operator+=(const GoneSolute& o) {
    drained += o.drained;
    deposited += o.deposited;
    return *this;
  }
  void visit(OverRanks& all) { all.sum(drained).sum(deposited); }
};

/// Before the particles that do not stay are removed.
void account_solute(const Constants& constants, const Fluid& fluid, const AdvectionWork& work, Accounts& accounts) {
  const Entries<const Quanta> solute = fluid.particles.solute, mass = fluid.particles.mass;
  const Entries<const std::uint8_t> gone = work.gone;
  const GoneSolute sums =
      over_ranks(constants.ranks, ordered<GoneSolute>(
                                      "drench::advection::solute", fluid.particles.count, KOKKOS_LAMBDA(const Index i) {
                                        if (gone(i)) return GoneSolute{solute(i), 0};
                                        return GoneSolute{0, mass(i) > 0 ? 0 : solute(i)};
                                      }));
  accounts.solute_drained += sums.drained;
  accounts.solute_deposited += sums.deposited;
}

}  // namespace

void advection(const Constants& constants, Fluid& fluid, const NeighborLists& lists, Bodies& bodies, Cloth& cloth,
               AdvectionWork& work, Accounts& accounts, const StepInfo& info, StepReport& report) {
  const Real dt = static_cast<Real>(info.dt);
  // What files move meets neither cloth nor bodies.
  const bool liquid = fluid.particles.total > 0, baked = constants.model.has_baked_liquid(),
             sheets = cloth.samples.count > 0 && !baked, moving_cloth = constants.model.has_moving_cloth();
  allocate_work(constants, fluid, cloth, work);
  fluid.particles.moved.advance();
  place_solids(constants, bodies, info);
  if (liquid && sheets && cloth.emission_ramp > 0) limit_fresh(constants, fluid, lists, cloth, work);
  if (moving_cloth) {
    place_pins(constants, cloth, info);
    move_cloth(constants, fluid, bodies, cloth, work, dt);
  } else if (liquid && sheets) {
    refresh_inverse_mass(constants, cloth);
  }
  if (!liquid) return;
  if (sheets) {
    sweep_paths(constants, fluid, lists, cloth, work, dt);
    fluid.exchange.add_up(work.hits, cloth.nodes.count);
    exchange_impulses(constants, fluid, cloth, work);
    fluid.exchange.add_up(work.momentum, 3 * cloth.nodes.count);
    apply_momentum(constants, cloth, work, info.dt);
    // Here, because the host waits below: who builds the samples' cells need not wait for their bounds.
    if (moving_cloth) refresh_samples_and_bounds(cloth);
  }
  const bool commanded = constants.model.has_commanded_body();
  if (commanded) clear_pushes(bodies);
  finish_fluid(constants, fluid, lists, bodies, commanded ? PushesOnBodies(constants, bodies) : PushesOnBodies{}, work,
               dt, info.time + info.dt, sheets);
  exec().fence("drench::advection::counts");
  if (sheets && moving_cloth) cloth.sample_bounds.set_made_from(cloth.moved);
  fluid.particles.ghosts = 0;
  const AdvectionCounts own = fluid.particles.count > 0 ? work.counts() : AdvectionCounts{};
  const AdvectionCounts counts = over_ranks(constants.ranks, own);
  report.collisions = counts.collisions;
  report.clamped = counts.clamped;
  if (commanded) {
    fluid.exchange.add_up(bodies.dynamic.pushed, 6 * bodies.count);
    add_impulses(bodies.given_by_liquid, pushes_on(constants, bodies));
  }
  if (counts.put_back_near > 0) check_put_back(constants, fluid, lists, cloth, work);
  if (counts.gone == 0) return;
  if (constants.model.has_solute()) account_solute(constants, fluid, work, accounts);
  if (counts.removed > 0) count_removed(fluid, work, info, counts, report);
  accounts.drained += counts.drained;
  fluid.particles.compact(work.gone, fluid.particles.count - static_cast<Index>(own.gone));
}

}  // namespace drench::kokkos_backend
