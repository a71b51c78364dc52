// Contact wicking, a part of stage diffusion (src/stages/diffusion.hpp, laws 4–6).

#include "contact_wicking.hpp"

#include <algorithm>
#include <cmath>

#include "laws/diffusion.hpp"
#include "laws/proximity.hpp"
#include "primitives/transfer.hpp"

namespace drench::kokkos_backend {
namespace {

constexpr Index none = -1;

/// What sample p sees on one side of its triangle.
struct Touch {
  Index triangle = none;
  Proximity near;
};

/// What the kernel over samples sees.
struct ContactSearch {
  Array<Index> node, sample_triangle, sample_cloth, triangle, node_cloth, found;
  Neighbors list;
  Array<Real3> sample_position, normal, position;
  Array<Real> area;
  Array<Material> materials;
  Array<double> weight, conductance, drop;
  double dt, density;  // s, kg/m³
  Double3 down;        // ĝ, 0 without gravity

  ContactSearch(const Device& d, double step)
      : node(d.samples.node),
        sample_triangle(d.samples.triangle),
        sample_cloth(d.samples.cloth),
        triangle(d.mesh.triangle),
        node_cloth(d.nodes.cloth),
        found(d.contact_work.triangle),
        list(d.sample_sample),
        sample_position(d.samples.position),
        normal(d.samples.normal),
        position(d.nodes.position),
        area(d.samples.area),
        materials(d.materials),
        weight(d.contact_work.weight),
        conductance(d.contact_work.conductance),
        drop(d.contact_work.drop),
        dt(step),
        density(d.model.rest_density) {
    const Double3 g = widen(d.gravity);
    const double size = Kokkos::sqrt(inner(g, g));
    if (size > 0) down = times(1 / size, g);
  }

  /// ρ0 (1−Φ) τ, kg/m².
  KOKKOS_INLINE_FUNCTION double load(const Material& m) const {
    return density * (1 - double(m.solid_fraction)) * double(m.thickness);
  }
  KOKKOS_INLINE_FUNCTION bool wicks(const Material& m) const { return m.contact_wicking != 0; }

  KOKKOS_INLINE_FUNCTION bool share_a_node(Index s, Index t) const {
    for (int a = 0; a < 3; ++a)
      for (int b = 0; b < 3; ++b)
        if (triangle(3 * s + a) == triangle(3 * t + b)) return true;
    return false;
  }

  /// Law 4; side 0: d·n > 0.
  KOKKOS_INLINE_FUNCTION void nearest(Index p, Touch* best) const {
    const Material& own = materials(sample_cloth(p));
    const Double3 n = widen(normal(p));
    Index last = none;
    const NeighborRow row = list.row(p);
    for (Index k = 0; k < row.count; ++k) {
      const Index other = row(k), t = sample_triangle(other);
      const Material& m = materials(sample_cloth(other));
      if (t == last || !wicks(m) || share_a_node(sample_triangle(p), t)) continue;
      last = t;
      Double3 x[4] = {widen(sample_position(p)), {}, {}, {}};
      for (Index c = 0; c < 3; ++c) x[c + 1] = widen(position(triangle(3 * t + c)));
      const Proximity near = proximity(false, x);
      const double reach = 0.75 * (double(own.thickness) + double(m.thickness)), height = inner(near.apart, n);
      if (!(near.distance > 0 && near.distance <= reach)) continue;
      if (!(2 * height * height >= near.distance * near.distance)) continue;
      Touch& touch = best[height > 0 ? 0 : 1];
      if (touch.triangle == none || near.distance < touch.near.distance ||
          (near.distance == touch.near.distance && t < touch.triangle))
        touch = {t, near};
    }
  }

  KOKKOS_INLINE_FUNCTION void operator()(const Index p) const {
    const Material& own = materials(sample_cloth(p));
    Touch best[2];
    if (wicks(own)) nearest(p, best);
    for (Index side = 0; side < 2; ++side) {
      const Index c = 2 * p + side, t = best[side].triangle;
      found(c) = t;
      if (t == none) continue;
      const Material& m = materials(node_cloth(triangle(3 * t)));
      conductance(c) = 0.5 * double(area(p)) *
                       laws::contact_conductance(load(own), double(own.thickness), double(own.diffusivity), load(m),
                                                 double(m.thickness), double(m.diffusivity), dt);
      drop(c) = inner(best[side].near.apart, down) * 0.5 *
                (1 / double(own.capillary_height) + 1 / double(m.capillary_height));
      for (int k = 0; k < 3; ++k) weight(3 * c + k) = -best[side].near.b[k + 1];
    }
  }
};

/// The nodes and weights of both ends of a contact: sample p and a point of a triangle.
struct Ends {
  Array<Index> sample_node, triangle, found;
  Array<double> sample_weight, found_weight;

  explicit Ends(const Device& d)
      : sample_node(d.samples.node),
        triangle(d.mesh.triangle),
        found(d.contact_work.triangle),
        sample_weight(d.samples.weight_exact),
        found_weight(d.contact_work.weight) {}
  /// Corner k of the sample (far false) or of what it touches (true).
  KOKKOS_INLINE_FUNCTION Index node(Index contact, bool far, int k) const {
    return far ? triangle(3 * found(contact) + k) : sample_node(3 * (contact / 2) + k);
  }
  KOKKOS_INLINE_FUNCTION double weight(Index contact, bool far, int k) const {
    return far ? found_weight(3 * contact + k) : sample_weight(3 * (contact / 2) + k);
  }
  KOKKOS_INLINE_FUNCTION Quanta part(Index contact, bool far, int k, Quanta amount) const {
    return split_part(amount, weight(contact, far, 0), weight(contact, far, 1), weight(contact, far, 2), k);
  }
};

void offer(Device& d, double dt, bool with_momentum) {
  const Ends ends(d);
  ContactWork& w = d.contact_work;
  const auto flow = w.flow, in = w.entering, out = w.leaving, liquid = d.nodes.liquid;
  const auto g = w.conductance, drop = w.drop;
  const auto capacity = d.nodes.capacity;
  const auto cloth = d.nodes.cloth;
  const auto materials = d.materials;
  const double q = d.quantum, scale = dt / d.quantum;
  const auto momentum = w.momentum;
  parallel(
      "drench::contact_wicking::clear", d.nodes.count, KOKKOS_LAMBDA(const Index n) {
        in(n) = out(n) = 0;
        if (with_momentum)
          for (int a = 0; a < 3; ++a) momentum(3 * n + a) = 0;
      });
  parallel(
      "drench::contact_wicking::offer", 2 * d.samples.count, KOKKOS_LAMBDA(const Index c) {
        flow(c) = 0;
        if (ends.found(c) == none) return;
        double s[2] = {0, 0};
        for (int far = 0; far < 2; ++far)
          for (int k = 0; k < 3; ++k) {
            const Index n = ends.node(c, far != 0, k);
            if (capacity(n) > 0) s[far] += ends.weight(c, far != 0, k) * (double(liquid(n)) * q / capacity(n));
          }
        const bool degenerate = materials(cloth(ends.node(c, false, 0))).degenerate != 0 ||
                                materials(cloth(ends.node(c, true, 0))).degenerate != 0;
        const double flux = laws::diffusion_flux(g(c), s[0], s[1], drop(c), degenerate);
        const Quanta o = static_cast<Quanta>(Kokkos::floor(Kokkos::abs(flux) * scale));
        if (o == 0) return;
        flow(c) = flux > 0 ? o : -o;
        for (int far = 0; far < 2; ++far)
          for (int k = 0; k < 3; ++k) {
            const Quanta part = whole_part(ends.weight(c, far != 0, k), o) + 1;
            const Index n = ends.node(c, far != 0, k);
            Kokkos::atomic_add((far != 0) == (flux > 0) ? &out(n) : &in(n), part);
          }
      });
}

/// Law 8: what reaches the other end brings the mean velocity of the nodes that it leaves. `to_far`: the end that gains.
KOKKOS_INLINE_FUNCTION void pass_momentum(const Ends& ends, const Array<Double3>& v, const Array<std::int64_t>& sums,
                                          double scale, Index c, bool to_far, Quanta amount) {
  Double3 mean;
  for (int k = 0; k < 3; ++k)
    mean = add(mean, times(double(ends.part(c, !to_far, k, amount)) / double(amount), v(ends.node(c, !to_far, k))));
  for (int k = 0; k < 3; ++k) {
    const Index n = ends.node(c, to_far, k);
    const Double3 gain = times(scale * double(ends.part(c, to_far, k, amount)), minus(mean, v(n)));
    Kokkos::atomic_add(&sums(3 * n), static_cast<std::int64_t>(Kokkos::round(gain.x)));
    Kokkos::atomic_add(&sums(3 * n + 1), static_cast<std::int64_t>(Kokkos::round(gain.y)));
    Kokkos::atomic_add(&sums(3 * n + 2), static_cast<std::int64_t>(Kokkos::round(gain.z)));
  }
}

/// The largest power of two with which what fills any node at 1000 m/s stays below 2^62: its momentum is then exact to
/// 2^-53 of that at 1 m/s.
double momentum_scale(const Model& m) {
  double most = 1;  // quanta
  for (const ClothMaterial& c : m.cloths)
    for (Index n = c.first_node; n < c.first_node + c.node_count; ++n)
      most = std::max(most, c.max_saturation * m.samples.node_capacity[static_cast<std::size_t>(n)] / m.quantum);
  return std::exp2(std::floor(62 - std::log2(1000 * most)));
}

void push_nodes(Device& d) {
  const auto v = d.diffusion_work.velocity;
  const auto momentum = d.contact_work.momentum;
  const auto liquid = d.nodes.liquid;
  const auto solid = d.nodes.solid_mass;
  const auto pinned = d.nodes.pinned;
  const double q = d.quantum, unit = d.quantum / d.contact_work.momentum_scale;
  parallel(
      "drench::contact_wicking::velocity", d.nodes.count, KOKKOS_LAMBDA(const Index n) {
        const double mass = double(solid(n)) + q * double(liquid(n));
        if (pinned(n) || !(mass > 0)) return;
        const double scale = unit / mass;
        v(n) = add(v(n), {scale * double(momentum(3 * n)), scale * double(momentum(3 * n + 1)),
                          scale * double(momentum(3 * n + 2))});
      });
}

void transfer(Device& d, bool with_momentum) {
  const Ends ends(d);
  ContactWork& w = d.contact_work;
  const auto flow = w.flow, in = w.entering, out = w.leaving, liquid = d.nodes.liquid, ceiling = d.nodes.max_quanta;
  const auto out_share = d.diffusion_work.out_share, in_share = d.diffusion_work.in_share;
  const auto velocity = d.diffusion_work.velocity;
  const auto momentum = w.momentum;
  const double scale = w.momentum_scale;
  parallel(
      "drench::contact_wicking::limit", d.nodes.count, KOKKOS_LAMBDA(const Index n) {
        out_share(n) = outflow_fraction(liquid(n), out(n));
        in_share(n) = inflow_fraction(ceiling(n), liquid(n), in(n));
      });
  parallel(
      "drench::contact_wicking::transfer", 2 * d.samples.count, KOKKOS_LAMBDA(const Index c) {
        const Quanta o = flow(c);
        if (o == 0) return;
        double share = 1;
        for (int far = 0; far < 2; ++far)
          for (int k = 0; k < 3; ++k) {
            if (!(ends.weight(c, far != 0, k) > 0)) continue;
            const Index n = ends.node(c, far != 0, k);
            share = Kokkos::fmin(share, (far != 0) == (o > 0) ? out_share(n) : in_share(n));
          }
        const Quanta t = limited(o > 0 ? o : -o, share);
        if (t == 0) return;
        if (with_momentum) pass_momentum(ends, velocity, momentum, scale, c, o < 0, t);
        for (int far = 0; far < 2; ++far)
          for (int k = 0; k < 3; ++k) {
            const Quanta part = ends.part(c, far != 0, k, t);
            if (part != 0) Kokkos::atomic_add(&liquid(ends.node(c, far != 0, k)), (far != 0) == (o > 0) ? -part : part);
          }
      });
}

}  // namespace

void find_contacts(Device& d, double dt, bool with_momentum) {
  ContactWork& w = d.contact_work;
  const auto both = 2 * static_cast<std::size_t>(d.samples.count), nodes = static_cast<std::size_t>(d.nodes.count);
  make_room(w.triangle, "drench::contact_wicking::triangle", both);
  make_room(w.weight, "drench::contact_wicking::weight", 3 * both);
  make_room(w.conductance, "drench::contact_wicking::conductance", both);
  make_room(w.drop, "drench::contact_wicking::drop", both);
  make_room(w.flow, "drench::contact_wicking::flow", both);
  make_room(w.entering, "drench::contact_wicking::entering", nodes);
  make_room(w.leaving, "drench::contact_wicking::leaving", nodes);
  if (with_momentum && w.momentum.extent(0) == 0) {
    make_room(w.momentum, "drench::contact_wicking::momentum", 3 * nodes);
    w.momentum_scale = momentum_scale(d.model);
  }
  parallel("drench::contact_wicking::find", d.samples.count, ContactSearch(d, dt));
}

void wick_through_contacts(Device& d, double dt, bool with_momentum) {
  offer(d, dt, with_momentum);
  transfer(d, with_momentum);
  if (with_momentum) push_nodes(d);
}

}  // namespace drench::kokkos_backend
