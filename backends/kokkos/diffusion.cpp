// Stage diffusion (src/stages/diffusion.hpp).

#include "laws/diffusion.hpp"

#include <algorithm>
#include <cmath>

#include "laws/flow.hpp"
#include "primitives/reduce.hpp"
#include "primitives/transfer.hpp"

namespace drench::kokkos_backend {
namespace {

/// M2_i of every sample, in diffusion_work.moment.
void moments(Device& d) {
  const auto count = d.sample_sample.count;
  const auto list = d.sample_sample.list;
  const auto x = d.samples.position, rest = d.samples.rest_position;
  const auto area = d.samples.area, moment = d.diffusion_work.moment;
  const auto cloth = d.samples.cloth;
  const auto materials = d.materials;
  const Real h = d.support;
  parallel(
      "drench::diffusion::moment", d.samples.count, KOKKOS_LAMBDA(const Index i) {
        Real sum = 0;
        const Index n = materials(cloth(i)).porous ? count(i) : 0;
        for (Index k = 0; k < n; ++k) {
          const Index j = list(i, k);
          if (cloth(j) != cloth(i) || laws::folded_apart(rest(i) - rest(j), h)) continue;
          const Real r = norm(x(i) - x(j));
          sum += area(j) * laws::diffusion_weight(r, h) * r * r;
        }
        moment(i) = sum;
      });
}

/// G_ij and the gravity term of every pair; G = 0 for pairs that exchange nothing.
void conductances(Device& d) {
  const auto count = d.sample_sample.count;
  const auto list = d.sample_sample.list;
  const auto g = d.diffusion_work.conductance, drop = d.diffusion_work.drop;
  const auto x = d.samples.position, rest = d.samples.rest_position;
  const auto area = d.samples.area, capacity = d.samples.capacity, moment = d.diffusion_work.moment;
  const auto cloth = d.samples.cloth;
  const auto materials = d.materials;
  const Real h = d.support, gravity = norm(d.gravity);
  const Real3 down = gravity > 0 ? (1 / gravity) * d.gravity : Real3{};
  parallel(
      "drench::diffusion::conductance", d.samples.count, KOKKOS_LAMBDA(const Index i) {
        const Index c = cloth(i);
        for (Index k = 0; k < count(i); ++k) {
          const Index j = list(i, k);
          Real conduct = 0, fall = 0;
          if (materials(c).porous && cloth(j) == c && !laws::folded_apart(rest(i) - rest(j), h)) {
            const Real3 separation = x(i) - x(j);
            conduct = laws::conductance(materials(c).diffusivity, capacity(i), area(i), capacity(j), area(j),
                                        laws::diffusion_weight(norm(separation), h), (moment(i) + moment(j)) / 2);
            fall = dot(separation, down) / materials(c).capillary_height;
          }
          g(i, k) = conduct;
          drop(i, k) = fall;
        }
      });
}

double largest_rate(Device& d) {
  const auto count = d.sample_sample.count;
  const auto g = d.diffusion_work.conductance, drop = d.diffusion_work.drop;
  const auto capacity = d.samples.capacity;
  return maximum(
      "drench::diffusion::rate", d.samples.count, KOKKOS_LAMBDA(const Index i) {
        double rate = 0;
        for (Index k = 0; k < count(i); ++k) rate += double(laws::diffusion_rate(g(i, k), drop(i, k), capacity(i)));
        return rate;
      });
}

/// Each pair is computed once, by its lower index i: transfer_work.pair(i, k) > 0 goes from j to i, < 0 from i to j.
void offer(Device& d, double dt) {
  const auto count = d.sample_sample.count;
  const auto list = d.sample_sample.list;
  const auto g = d.diffusion_work.conductance, drop = d.diffusion_work.drop;
  const auto s = d.samples.saturation;
  const auto cloth = d.samples.cloth;
  const auto materials = d.materials;
  const auto pair = d.transfer_work.pair;
  const auto entering = d.transfer_work.entering, leaving = d.transfer_work.leaving;
  const double scale = dt / d.quantum;
  parallel(
      "drench::diffusion::offer", d.samples.count, KOKKOS_LAMBDA(const Index i) {
        const bool degenerate = materials(cloth(i)).degenerate != 0;
        for (Index k = 0; k < count(i); ++k) {
          const Index j = list(i, k);
          if (j < i || !(g(i, k) > 0)) continue;
          const Real flux = laws::diffusion_flux(g(i, k), s(i), s(j), drop(i, k), degenerate);
          const Quanta o = static_cast<Quanta>(Kokkos::floor(double(Kokkos::abs(flux)) * scale));
          pair(i, k) = flux > 0 ? o : -o;
          if (o == 0) continue;
          Kokkos::atomic_add(&leaving(flux > 0 ? j : i), o);
          Kokkos::atomic_add(&entering(flux > 0 ? i : j), o);
        }
      });
}

void transfer(Device& d) {
  const auto count = d.sample_sample.count;
  const auto list = d.sample_sample.list;
  const auto g = d.diffusion_work.conductance;
  const auto pair = d.transfer_work.pair;
  const auto in = d.transfer_work.inflow_share, out = d.transfer_work.outflow_share;
  const auto net = d.diffusion_work.net;
  parallel(
      "drench::diffusion::clear", d.samples.count, KOKKOS_LAMBDA(const Index i) { net(i) = 0; });
  parallel(
      "drench::diffusion::transfer", d.samples.count, KOKKOS_LAMBDA(const Index i) {
        Quanta own = 0;
        for (Index k = 0; k < count(i); ++k) {
          const Index j = list(i, k);
          if (j < i || !(g(i, k) > 0)) continue;
          const Quanta o = pair(i, k);
          if (o == 0) continue;
          const double from = out(o > 0 ? j : i), to = in(o > 0 ? i : j);
          const Quanta t = limited(o > 0 ? o : -o, from < to ? from : to);
          const Quanta gain = o > 0 ? t : -t;
          own += gain;
          Kokkos::atomic_add(&net(j), -gain);
        }
        Kokkos::atomic_add(&net(i), own);
      });
}

void apply_net(Device& d) {
  const auto start = d.nodes.sample_start, item = d.nodes.sample_item;
  const auto weight = d.samples.weight_exact;
  const auto net = d.diffusion_work.net;
  const auto liquid = d.nodes.liquid;
  parallel(
      "drench::diffusion::apply", d.nodes.count, KOKKOS_LAMBDA(const Index n) {
        Quanta gain = 0;
        for (Index e = start(n); e < start(n + 1); ++e) {
          const Index p = item(e) / 4;
          gain += split_part(net(p), weight(3 * p), weight(3 * p + 1), weight(3 * p + 2), item(e) % 4);
        }
        liquid(n) += gain;
      });
}

}  // namespace

void diffusion(Device& d, const StepInfo& info, StepReport& report) {
  if (d.samples.count == 0) return;
  const auto samples = static_cast<std::size_t>(d.samples.count);
  make_room(d.transfer_work.pair, "drench::transfer::pair", d.sample_sample.list);
  make_room(d.diffusion_work.conductance, "drench::diffusion::conductance", d.sample_sample.list);
  make_room(d.diffusion_work.drop, "drench::diffusion::drop", d.sample_sample.list);
  make_room(d.diffusion_work.moment, "drench::diffusion::moment", samples);
  make_room(d.diffusion_work.net, "drench::diffusion::net", samples);
  refresh_samples(d);
  moments(d);
  conductances(d);
  const int substeps = std::max(1, static_cast<int>(std::ceil(info.dt * largest_rate(d) / 0.5)));
  for (int k = 0; k < substeps; ++k) {
    refresh_saturation(d);
    clear_transfers(d, false);
    offer(d, info.dt / substeps);
    limit_inflow(d);
    limit_outflow(d);
    transfer(d);
    apply_net(d);
  }
  report.diffusion_substeps = substeps;
}

}  // namespace drench::kokkos_backend
