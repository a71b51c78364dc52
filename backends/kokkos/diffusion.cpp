// Stage diffusion (src/stages/diffusion.hpp).

#include "laws/diffusion.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "contact_wicking.hpp"
#include "device_copy.hpp"
#include "primitives/reduce.hpp"
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

/// The gravity term of every pair.
void drops(Device& d) {
  const auto pair = d.diffusion_work.pair;
  const auto drop = d.diffusion_work.drop;
  const auto x = d.nodes.position;
  const auto cloth = d.nodes.cloth;
  const auto materials = d.materials;
  const Real gravity = norm(d.gravity);
  const Real3 down = gravity > 0 ? (1 / gravity) * d.gravity : Real3{};
  parallel(
      "drench::diffusion::drop", d.diffusion_work.pairs, KOKKOS_LAMBDA(const Index e) {
        const Index i = pair(2 * e), j = pair(2 * e + 1);
        drop(e) = double(dot(x(i) - x(j), down) / materials(cloth(i)).capillary_height);
      });
}

double largest_rate(Device& d) {
  const auto start = d.diffusion_work.node_start, item = d.diffusion_work.node_item;
  const auto g = d.diffusion_work.conductance, drop = d.diffusion_work.drop;
  const auto capacity = d.nodes.capacity;
  const auto cloth = d.nodes.cloth;
  const auto materials = d.materials;
  return maximum(
      "drench::diffusion::rate", d.nodes.count, KOKKOS_LAMBDA(const Index n) {
        const Material& m = materials(cloth(n));
        const double most = m.degenerate ? double(m.max_saturation) : 1;
        double rate = 0;
        for (Index k = start(n); k < start(n + 1); ++k) {
          const Index e = item(k) / 2;
          rate += g(e) * (most + Kokkos::abs(drop(e)));
        }
        return capacity(n) > 0 ? rate / capacity(n) : 0.0;
      });
}

/// flow(e) > 0 goes from the pair's second node to its first, < 0 the other way.
void offer(Device& d, double dt) {
  const auto pair = d.diffusion_work.pair;
  const auto g = d.diffusion_work.conductance, drop = d.diffusion_work.drop;
  const auto flow = d.diffusion_work.flow, liquid = d.nodes.liquid;
  const auto capacity = d.nodes.capacity;
  const auto cloth = d.nodes.cloth;
  const auto materials = d.materials;
  const double q = d.quantum, scale = dt / d.quantum;
  parallel(
      "drench::diffusion::offer", d.diffusion_work.pairs, KOKKOS_LAMBDA(const Index e) {
        flow(e) = 0;
        if (!(g(e) > 0)) return;
        const Index i = pair(2 * e), j = pair(2 * e + 1);
        const double si = double(liquid(i)) * q / capacity(i), sj = double(liquid(j)) * q / capacity(j);
        const double flux = laws::diffusion_flux(g(e), si, sj, drop(e), materials(cloth(i)).degenerate != 0);
        const Quanta o = static_cast<Quanta>(Kokkos::floor(Kokkos::abs(flux) * scale));
        flow(e) = flux > 0 ? o : -o;
      });
}

void limit(Device& d) {
  const auto start = d.diffusion_work.node_start, item = d.diffusion_work.node_item;
  const auto flow = d.diffusion_work.flow, liquid = d.nodes.liquid, ceiling = d.nodes.max_quanta;
  const auto out_share = d.diffusion_work.out_share, in_share = d.diffusion_work.in_share;
  parallel(
      "drench::diffusion::limit", d.nodes.count, KOKKOS_LAMBDA(const Index n) {
        Quanta out = 0, in = 0;
        for (Index k = start(n); k < start(n + 1); ++k) {
          const Quanta gain = item(k) % 2 == 0 ? flow(item(k) / 2) : -flow(item(k) / 2);
          (gain > 0 ? in : out) += gain > 0 ? gain : -gain;
        }
        out_share(n) = outflow_fraction(liquid(n), out);
        in_share(n) = inflow_fraction(ceiling(n), liquid(n), in);
      });
}

/// Does liquid diffuse in cloth that moves? If not, no velocity is touched.
bool carries_momentum(const Model& m) {
  return std::any_of(m.cloths.begin(), m.cloths.end(),
                     [](const ClothMaterial& c) { return c.dynamics && c.porous && c.diffusivity > 0; });
}

/// The nodes' velocities in double, so that they are rounded once a step and not once a sub-step.
void take_velocities(Device& d) {
  DiffusionWork& w = d.diffusion_work;
  make_room(w.velocity, "drench::diffusion::velocity", static_cast<std::size_t>(d.nodes.count));
  make_room(w.next_velocity, "drench::diffusion::next_velocity", static_cast<std::size_t>(d.nodes.count));
  const auto v = d.nodes.velocity;
  const auto wide = w.velocity;
  parallel(
      "drench::diffusion::take_velocity", d.nodes.count, KOKKOS_LAMBDA(const Index n) { wide(n) = widen(v(n)); });
}

void give_velocities(Device& d) {
  const auto v = d.nodes.velocity;
  const auto wide = d.diffusion_work.velocity;
  parallel(
      "drench::diffusion::give_velocity", d.nodes.count, KOKKOS_LAMBDA(const Index n) { v(n) = narrow(wide(n)); });
}

void transfer(Device& d, bool with_momentum) {
  DiffusionWork& w = d.diffusion_work;
  const auto pair = w.pair;
  const auto flow = w.flow;
  const auto out_share = w.out_share, in_share = w.in_share;
  parallel(
      "drench::diffusion::transfer", w.pairs, KOKKOS_LAMBDA(const Index e) {
        const Quanta o = flow(e);
        if (o == 0) return;
        const Index receiver = pair(o > 0 ? 2 * e : 2 * e + 1), donor = pair(o > 0 ? 2 * e + 1 : 2 * e);
        const Quanta t = limited(o > 0 ? o : -o, Kokkos::fmin(out_share(donor), in_share(receiver)));
        flow(e) = o > 0 ? t : -t;
      });
  const auto start = w.node_start, item = w.node_item;
  const auto liquid = d.nodes.liquid;
  const auto v = w.velocity, next = w.next_velocity;
  const auto solid = d.nodes.solid_mass;
  const auto pinned = d.nodes.pinned;
  const double q = d.quantum;
  parallel(
      "drench::diffusion::apply", d.nodes.count, KOKKOS_LAMBDA(const Index n) {
        Quanta gain = 0;
        Double3 push;  // Σ_in t (v_donor − v_n), quanta · m/s
        for (Index k = start(n); k < start(n + 1); ++k) {
          const Quanta part = item(k) % 2 == 0 ? flow(item(k) / 2) : -flow(item(k) / 2);
          gain += part;
          if (with_momentum && part > 0) push = add(push, times(double(part), minus(v(pair(item(k) ^ 1)), v(n))));
        }
        liquid(n) += gain;
        if (!with_momentum) return;
        const double mass = double(solid(n)) + q * double(liquid(n));
        next(n) = pinned(n) || !(mass > 0) ? v(n) : add(v(n), times(q / mass, push));
      });
  if (with_momentum) std::swap(w.velocity, w.next_velocity);
}

}  // namespace

void diffusion(Device& d, const StepInfo& info, StepReport& report) {
  if (d.samples.count == 0 || !(info.dt > 0)) return;
  upload_pairs(d);
  drops(d);
  const int substeps = std::max(1, static_cast<int>(std::ceil(info.dt * largest_rate(d) / 0.5)));
  const double dt = info.dt / substeps;
  const bool contacts = d.model.has_contact_wicking();
  const bool with_momentum = carries_momentum(d.model);
  if (contacts) find_contacts(d, dt, with_momentum);
  if (with_momentum) take_velocities(d);
  for (int k = 0; k < substeps; ++k) {
    offer(d, dt);
    limit(d);
    transfer(d, with_momentum);
    if (contacts) wick_through_contacts(d, dt, with_momentum);
    if (k + 1 < substeps && d.model.has_reservoirs()) reservoir(d, info, report);
  }
  if (with_momentum) give_velocities(d);
  report.diffusion_substeps = substeps;
}

}  // namespace drench::kokkos_backend
