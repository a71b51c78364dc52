// Stage diffusion (src/stages/diffusion.hpp). Two kernels over the nodes a sub-step: each node computes the flows of its own
// pairs, so that both of a pair's come to the same number.

#include "laws/diffusion.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "contact_wicking.hpp"
#include "device_copy.hpp"
#include "diffusion.hpp"
#include "pipeline/substeps.hpp"
#include "primitives/transfer.hpp"

namespace drench::kokkos_backend {
namespace {

/// The model's pairs with their conductances, once.
void upload_pairs(Device& d) {
  DiffusionWork& w = d.diffusion_work;
  if (w.pair.extent(0) > 0) return;
  const FabricPairs& fabric = d.model.fabric;
  std::vector<double> conductance(fabric.weight.size());
  const std::vector<double>& capacity = d.model.samples.node_capacity;
  for (std::size_t e = 0; e < conductance.size(); ++e) {
    const auto i = static_cast<std::size_t>(fabric.nodes[e][0]), j = static_cast<std::size_t>(fabric.nodes[e][1]);
    const ClothMaterial& c = d.model.cloths[static_cast<std::size_t>(d.model.mesh.node_cloth[i])];
    if (capacity[i] > 0 && capacity[j] > 0)
      conductance[e] = d.model.rest_density * (1 - c.solid_fraction) * c.thickness * c.diffusivity * fabric.weight[e];
  }
  w.pairs = static_cast<Index>(conductance.size());
  w.pair = to_device<Index>("drench::diffusion::pair", flat(fabric.nodes));
  w.conductance = to_device<double>("drench::diffusion::conductance", conductance);
  w.node_start = to_device<Index>("drench::diffusion::node_start", fabric.of_node.start);
  w.node_item = to_device<Index>("drench::diffusion::node_item", fabric.of_node.item);
  w.drop = Array<double>("drench::diffusion::drop", conductance.size());
  w.flow = Array<Quanta>("drench::diffusion::flow", conductance.size());
  const auto nodes = static_cast<std::size_t>(d.nodes.count);
  w.out_share = Array<double>("drench::diffusion::out_share", nodes);
  w.in_share = Array<double>("drench::diffusion::in_share", nodes);
}

/// What the kernels see of the pairs.
struct NodePairs {
  Entries<Index> pair, start, item, cloth;
  Entries<double> conductance, drop, capacity;
  Entries<Quanta> liquid;
  Entries<Material> material;

  explicit NodePairs(const Device& d)
      : pair(d.diffusion_work.pair),
        start(d.diffusion_work.node_start),
        item(d.diffusion_work.node_item),
        cloth(d.nodes.cloth),
        conductance(d.diffusion_work.conductance),
        drop(d.diffusion_work.drop),
        capacity(d.nodes.capacity),
        liquid(d.nodes.liquid),
        material(d.materials) {}

  /// Of pair e, quanta, > 0 to its first node: what the law wants to flow, `scale` = Δt/q.
  KOKKOS_INLINE_FUNCTION Quanta offer(Index e, double q, double scale) const {
    if (!(conductance(e) > 0)) return 0;
    const Index i = pair(2 * e), j = pair(2 * e + 1);
    const double si = double(liquid(i)) * q / capacity(i), sj = double(liquid(j)) * q / capacity(j);
    const double flux = laws::diffusion_flux(conductance(e), si, sj, drop(e), material(cloth(i)).degenerate != 0);
    const Quanta o = static_cast<Quanta>(Kokkos::floor(Kokkos::abs(flux) * scale));
    return flux > 0 ? o : -o;
  }
};

/// φ of every node; the offers in `flow`. In the first sub-step also the velocities in double: they are rounded once a step
/// and not once a sub-step.
void limit(Device& d, double dt, bool take_velocity) {
  const NodePairs pairs(d);
  const Entries<Quanta> flow = d.diffusion_work.flow, ceiling = d.nodes.max_quanta;
  const Entries<double> out_share = d.diffusion_work.out_share, in_share = d.diffusion_work.in_share;
  const Entries<Real3> v = d.nodes.velocity;
  const Entries<Double3> wide = d.diffusion_work.velocity;
  const double q = d.quantum, scale = dt / d.quantum;
  parallel(
      "drench::diffusion::limit", d.nodes.count, KOKKOS_LAMBDA(const Index n) {
        Quanta out = 0, in = 0;
        for (Index k = pairs.start(n); k < pairs.start(n + 1); ++k) {
          const bool first = pairs.item(k) % 2 == 0;
          const Quanta o = pairs.offer(pairs.item(k) / 2, q, scale);
          if (first) flow(pairs.item(k) / 2) = o;
          const Quanta gain = first ? o : -o;
          (gain > 0 ? in : out) += gain > 0 ? gain : -gain;
        }
        out_share(n) = outflow_fraction(pairs.liquid(n), out);
        in_share(n) = inflow_fraction(ceiling(n), pairs.liquid(n), in);
        if (take_velocity) wide(n) = widen(v(n));
      });
}

/// Does liquid diffuse in cloth that moves? If not, no velocity is touched.
bool carries_momentum(const Model& m) {
  return std::any_of(m.cloths.begin(), m.cloths.end(),
                     [](const ClothMaterial& c) { return c.dynamics && c.porous && c.diffusivity > 0; });
}

void make_room_for_velocities(Device& d) {
  DiffusionWork& w = d.diffusion_work;
  make_room(w.velocity, "drench::diffusion::velocity", static_cast<std::size_t>(d.nodes.count));
  make_room(w.next_velocity, "drench::diffusion::next_velocity", static_cast<std::size_t>(d.nodes.count));
}

void give_velocities(Device& d) {
  const auto v = d.nodes.velocity;
  const auto wide = d.diffusion_work.velocity;
  parallel(
      "drench::diffusion::give_velocity", d.nodes.count, KOKKOS_LAMBDA(const Index n) { v(n) = narrow(wide(n)); });
}

/// `give_velocity`: the new velocities are the step's last, and go to the nodes.
void transfer(Device& d, bool with_momentum, bool give_velocity) {
  DiffusionWork& w = d.diffusion_work;
  const Entries<Index> pair = w.pair, start = w.node_start, item = w.node_item;
  const Entries<Quanta> flow = w.flow, liquid = d.nodes.liquid;
  const Entries<double> out_share = w.out_share, in_share = w.in_share;
  const Entries<Double3> v = w.velocity, next = w.next_velocity;
  const Entries<Real3> velocity = d.nodes.velocity;
  const Entries<Real> solid = d.nodes.solid_mass;
  const Entries<std::uint8_t> pinned = d.nodes.pinned;
  const double q = d.quantum;
  parallel(
      "drench::diffusion::transfer", d.nodes.count, KOKKOS_LAMBDA(const Index n) {
        Quanta gain = 0;
        Double3 push;  // Σ_in t (v_donor − v_n), quanta · m/s
        for (Index k = start(n); k < start(n + 1); ++k) {
          const Index e = item(k) / 2, other = pair(item(k) ^ 1);
          const Quanta o = item(k) % 2 == 0 ? flow(e) : -flow(e);
          if (o == 0) continue;
          const Quanta t = limited(o > 0 ? o : -o, o > 0 ? Kokkos::fmin(out_share(other), in_share(n))
                                                         : Kokkos::fmin(out_share(n), in_share(other)));
          gain += o > 0 ? t : -t;
          if (with_momentum && o > 0 && t > 0) push = add(push, times(double(t), minus(v(other), v(n))));
        }
        liquid(n) += gain;
        if (!with_momentum) return;
        const double mass = double(solid(n)) + q * double(liquid(n));
        const Double3 after = pinned(n) || !(mass > 0) ? v(n) : add(v(n), times(q / mass, push));
        if (give_velocity)
          velocity(n) = narrow(after);
        else
          next(n) = after;
      });
  if (with_momentum) std::swap(w.velocity, w.next_velocity);
}

}  // namespace

void launch_diffusion_rate(Device& d) {
  if (d.samples.count == 0) return;
  upload_pairs(d);
  DiffusionWork& w = d.diffusion_work;
  if (w.rate.data() == nullptr)
    w.rate = decltype(w.rate)(Kokkos::ViewAllocateWithoutInitializing("drench::diffusion::largest_rate"));
  const NodePairs pairs(d);
  const Entries<Real3> x = d.nodes.position;
  const Real gravity = norm(d.gravity);
  const Real3 down = gravity > 0 ? (1 / gravity) * d.gravity : Real3{};
  Kokkos::parallel_reduce(
      "drench::diffusion::rate", Range(0, d.nodes.count),
      KOKKOS_LAMBDA(const Index n, double& largest) {
        const Material& m = pairs.material(pairs.cloth(n));
        const double most = m.degenerate ? double(m.max_saturation) : 1;
        double rate = 0;
        for (Index k = pairs.start(n); k < pairs.start(n + 1); ++k) {
          const Index e = pairs.item(k) / 2, i = pairs.pair(2 * e), j = pairs.pair(2 * e + 1);
          const double drop = double(dot(x(i) - x(j), down) / pairs.material(pairs.cloth(i)).capillary_height);
          if (i == n) pairs.drop(e) = drop;
          rate += pairs.conductance(e) * (most + Kokkos::abs(drop));
        }
        rate = pairs.capacity(n) > 0 ? rate / pairs.capacity(n) : 0.0;
        if (rate > largest) largest = rate;
      },
      Kokkos::Max<double, Kokkos::SharedHostPinnedSpace>(w.rate));
  w.rate_launched = true;
  w.rate_waited = false;
}

void diffusion(Device& d, const StepInfo& info, StepReport& report) {
  if (d.samples.count == 0 || !(info.dt > 0)) return;
  DiffusionWork& w = d.diffusion_work;
  if (!w.rate_launched) launch_diffusion_rate(d);
  if (!w.rate_waited) ExecSpace().fence("drench::diffusion::rate");
  w.rate_launched = false;
  const int substeps = diffusion_substeps(info.dt * std::max(0.0, w.rate()) / 0.5, info, report);
  const double dt = info.dt / substeps;
  const bool contacts = d.model.has_contact_wicking();
  const bool with_momentum = carries_momentum(d.model);
  if (contacts) find_contacts(d, dt, with_momentum);
  if (with_momentum) make_room_for_velocities(d);
  for (int k = 0; k < substeps; ++k) {
    const bool last = k + 1 == substeps;
    limit(d, dt, with_momentum && k == 0);
    transfer(d, with_momentum, last && !contacts);
    if (contacts) wick_through_contacts(d, dt, with_momentum);
    if (!last && d.model.has_reservoirs()) reservoir(d, info, report);
  }
  if (with_momentum && contacts) give_velocities(d);
  report.diffusion_substeps = substeps;
}

}  // namespace drench::kokkos_backend
