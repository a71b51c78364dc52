// Stage advection (law: src/stages/advection.hpp).

#include "stages/advection.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

#include "advection_cloth.hpp"
#include "advection_sweep.hpp"
#include "device_copy.hpp"
#include "laws/collision.hpp"
#include "laws/contact.hpp"
#include "pins.hpp"
#include "rigid_bodies.hpp"

namespace drench::kokkos_backend {
namespace {

constexpr double momentum_units = 256;  // per quantum · m/s

/// Adds w · m · Δv (m in quanta) to a node's momentum, in fixed point: exact in any order.
KOKKOS_INLINE_FUNCTION void add_momentum(const Entries<std::int64_t>& momentum, Index node, double quanta,
                                         const Double3& dv) {
  const double scale = momentum_units * quanta;
  Kokkos::atomic_add(&momentum(3 * node), static_cast<std::int64_t>(Kokkos::floor(scale * dv.x + 0.5)));
  Kokkos::atomic_add(&momentum(3 * node + 1), static_cast<std::int64_t>(Kokkos::floor(scale * dv.y + 0.5)));
  Kokkos::atomic_add(&momentum(3 * node + 2), static_cast<std::int64_t>(Kokkos::floor(scale * dv.z + 0.5)));
}

void allocate(Device& d) {
  AdvectionWork& w = d.advection_work;
  if (w.counts.data() == nullptr) {
    w.counts = decltype(w.counts)(Kokkos::ViewAllocateWithoutInitializing("drench::advection::counts"));
    w.motion = Kokkos::View<ClothMotion, MemSpace>("drench::advection::motion");
    w.near_count = Kokkos::View<Index, MemSpace>("drench::advection::near_count");
  }
  const auto nodes = static_cast<std::size_t>(d.nodes.count);
  if (w.momentum.extent(0) != 3 * nodes) {
    w.start = Array<Real3>("drench::advection::start", nodes);
    w.momentum = Array<std::int64_t>("drench::advection::momentum", 3 * nodes);
    w.hits = Array<Index>("drench::advection::hits", nodes);
    w.box = Array<Box>("drench::advection::box", static_cast<std::size_t>(d.mesh.triangles));
  }
  const std::size_t capacity = d.fluid.position.extent(0);
  if (w.gone.extent(0) < capacity) {
    w.gone = Array<std::uint8_t>("drench::advection::gone", capacity);
    w.end = Array<Real3>("drench::advection::end", capacity);
    if (d.samples.count > 0) {
      w.hit_triangle = Array<Index>("drench::advection::hit_triangle", capacity);
      w.hit_weight = Array<Real3>("drench::advection::hit_weight", capacity);
      w.hit_normal = Array<Real3>("drench::advection::hit_normal", capacity);
      if (d.crossed.data() == nullptr) d.crossed = Kokkos::View<CrossedCloth, MemSpace>("drench::advection::crossed");
      if (!on_host) w.near = Array<Index>("drench::advection::near", capacity);
    }
  }
}

/// Law 1: limits the speed of fresh particles relative to the cloth; the cloth gets the momentum.
void limit_fresh(Device& d) {
  const Entries<Real3> position = d.fluid.position, velocity = d.fluid.velocity, sample_position = d.samples.position,
                       node_velocity = d.nodes.velocity;
  const Entries<Quanta> mass = d.fluid.mass;
  const Entries<Real> age = d.fluid.age, weight = d.samples.weight;
  const Entries<std::uint8_t> origin = d.fluid.origin;
  const Neighbors list(d.fluid_sample);
  const Entries<Index> sample_node = d.samples.node;
  const Entries<std::int64_t> momentum = d.advection_work.momentum;
  const Real ramp = d.emission_ramp, base_speed = d.spacing / d.emission_ramp, fall = 2 * norm(d.gravity);
  parallel(
      "drench::advection::fresh", d.fluid.count, KOKKOS_LAMBDA(const Index i) {
        if (origin(i) != static_cast<std::uint8_t>(Origin::cloth) || !(age(i) < ramp)) return;
        Index nearest = -1;
        Real best = 0;
        const NeighborRow near = list.row(i);
        for (Index k = 0; k < near.count; ++k) {
          const Index p = near(k);
          const Real3 apart = position(i) - sample_position(p);
          const Real square = dot(apart, apart);
          if (nearest >= 0 && !(square < best)) continue;
          nearest = p;
          best = square;
        }
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
void exchange_impulses(Device& d) {
  const AdvectionWork& w = d.advection_work;
  const Entries<Real3> velocity = d.fluid.velocity, node_velocity = d.nodes.velocity, hit_weight = w.hit_weight,
                       hit_normal = w.hit_normal;
  const Entries<Quanta> mass = d.fluid.mass;
  const Entries<Real> inverse_mass = d.nodes.inverse_mass;
  const Entries<Index> hit_triangle = w.hit_triangle, hits = w.hits, triangle = d.mesh.triangle;
  const Entries<std::int64_t> momentum = w.momentum;
  const double quantum = d.quantum;
  parallel(
      "drench::advection::impulse", d.fluid.count, KOKKOS_LAMBDA(const Index i) {
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

/// v_n += u_n p_n; the sums are zero again for the next step.
void apply_momentum(Device& d) {
  const auto velocity = d.nodes.velocity;
  const auto inverse_mass = d.nodes.inverse_mass;
  const auto momentum = d.advection_work.momentum;
  const auto hits = d.advection_work.hits;
  const auto near_count = d.advection_work.near_count;
  const double unit = d.quantum / momentum_units;
  parallel(
      "drench::advection::momentum", d.nodes.count, KOKKOS_LAMBDA(const Index n) {
        const Double3 p{static_cast<double>(momentum(3 * n)), static_cast<double>(momentum(3 * n + 1)),
                        static_cast<double>(momentum(3 * n + 2))};
        velocity(n) = narrow(add(widen(velocity(n)), times(unit * static_cast<double>(inverse_mass(n)), p)));
        for (Index a = 0; a < 3; ++a) momentum(3 * n + a) = 0;
        hits(n) = 0;
        if (n == 0) near_count() = 0;
      });
}

/// Laws 4 and 5: bodies' failsafe, new position and age, and who left the domain. `swept`: x1 is known.
void finish_fluid(Device& d, Real dt, bool swept) {
  const AdvectionWork& w = d.advection_work;
  const Entries<Real3> position = d.fluid.position, velocity = d.fluid.velocity, end = w.end, shift = d.work.shift;
  const Entries<Real> age = d.fluid.age;
  const Entries<Quanta> mass = d.fluid.mass;
  const Entries<std::uint8_t> gone = w.gone;
  const Entries<Index> hit_triangle = w.hit_triangle, near_cloth = d.fluid_sample.count;
  const bool listed = swept && d.fluid_sample.rows == d.fluid.count;
  const Slice<Solid> solids = d.solids;
  const Vec3 &min = d.model.scene.domain.min, &max = d.model.scene.domain.max;
  const Double3 lo{min[0], min[1], min[2]}, hi{max[0], max[1], max[2]};
  Kokkos::parallel_reduce(
      "drench::advection::finish", Range(0, d.fluid.count),
      KOKKOS_LAMBDA(const Index i, AdvectionCounts& counts) {
        Real3 v = velocity(i), x = swept ? end(i) : position(i) + dt * v + shift(i);
        if (swept && hit_triangle(i) >= 0) ++counts.collisions;
        bool put_back = false;
        for (std::int64_t b = 0; b < solids.count; ++b) {
          const SolidDistance body = solid_distance(solids(b), x, Real3{});
          if (!(body.phi < 0)) continue;
          v = without_inward(v, body.normal, surface_velocity(solids(b), x, Real3{}));
          x += to_distance(solids(b), x, Real3{}, body, 0);
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
        gone(i) = outside ? 1 : 0;
        if (outside || !(mass(i) > 0)) ++counts.gone;
        if (!outside) return;
        ++counts.removed;
        const double square = double(dot(v, v));
        if (square > counts.square) counts.square = square;
        counts.drained += static_cast<std::int64_t>(mass(i));
      },
      w.counts);
}

/// Of the particles that leave those that are faster than `limit`, m/s. Asked for only in steps that are suspicious.
SomeParticles fled(const Device& d, double limit) {
  const auto gone = to_host<std::uint8_t>(d.advection_work.gone, d.fluid.count);
  const auto id = to_host<std::int64_t>(d.fluid.id, d.fluid.count);
  const auto velocity = to_host<Vec3>(d.fluid.velocity, d.fluid.count);
  std::vector<std::int64_t> ids;
  for (std::size_t i = 0; i < gone.size(); ++i)
    if (gone[i] != 0 && std::hypot(velocity[i][0], velocity[i][1], velocity[i][2]) > limit) ids.push_back(id[i]);
  SomeParticles some{static_cast<std::int64_t>(ids.size()), {}};
  std::partial_sort_copy(ids.begin(), ids.end(), some.lowest.begin(), some.lowest.end());
  return some;
}

}  // namespace

void advection(Device& d, const StepInfo& info, StepReport& report) {
  const Real dt = static_cast<Real>(info.dt);
  const bool liquid = d.fluid.count > 0, cloth = d.samples.count > 0, moving_cloth = d.model.has_moving_cloth();
  allocate(d);
  d.measured.fresh = false;
  place_solids(d, info.dt);
  if (liquid && cloth && d.emission_ramp > 0) limit_fresh(d);
  if (moving_cloth) {
    place_pins(d, info);
    move_cloth(d, dt);
  } else if (liquid && cloth) {
    refresh_inverse_mass(d);
  }
  if (!liquid) return;
  AdvectionWork& w = d.advection_work;
  if (cloth) {
    sweep_paths(d, dt);
    exchange_impulses(d);
    apply_momentum(d);
    // Here, because the host waits below: who builds the samples' cells need not wait for their bounds.
    if (moving_cloth) refresh_samples_and_bounds(d);
  }
  finish_fluid(d, dt, cloth);
  ExecSpace().fence("drench::advection::counts");
  d.sample_bounds_fresh = cloth && d.samples_fresh && moving_cloth;
  const AdvectionCounts counts = w.counts();
  report.collisions = counts.collisions;
  report.clamped = counts.clamped;
  if (counts.put_back_near > 0) check_put_back(d);
  if (counts.removed == 0) return;
  report.fled_speed = std::sqrt(counts.square);
  const bool fast = report.fled_speed > info.fluid_speed_limit;
  if (fast || (counts.removed >= 100 && 4 * counts.removed > d.next_id))
    report.fled = fled(d, fast ? info.fluid_speed_limit : -1);
  d.drained += counts.drained;
  d.compact_fluid(w.gone, d.fluid.count - static_cast<Index>(counts.gone));
}

}  // namespace drench::kokkos_backend
